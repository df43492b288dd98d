"""Names and their stand-ins."""

from __future__ import annotations

import random
import string

import pytest

from retime.issue_report.stand_ins import StandIns, alike
from retime.issue_report.vocabulary import words_of_modules

NUMBERS = [b"1_0", b"0,5", b"0.0-7.5", b"1e999", b"-.5", b"+3.", b"nan", b"2024-01-02T10:11:12.5Z", b"00:01:02;12"]


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_stay_in_any_spelling(text) -> None:
    assert StandIns().in_words(text) == text


@pytest.mark.parametrize("seed", range(5))
def test_stand_ins_are_as_many_and_as_long_as_the_names(seed) -> None:
    rng = random.Random(seed)
    letters = string.ascii_letters + "äß名𝄞"
    names = {"".join(rng.choices(letters, k=rng.choice([2, 3, 5, 9]))) for _ in range(300)}
    stand_ins = StandIns()
    found = {name: stand_ins[name.encode()] for name in names}
    assert all(len(stand_in) == len(name.encode()) for name, stand_in in found.items())
    # Two letters of three bytes leave few bytes to count with; those of ASCII never meet.
    plain = [name for name in names if name.isascii()]
    assert len({found[name] for name in plain}) == len(plain)
    assert {name: stand_ins[name.encode()] for name in names} == found


def test_what_is_no_utf8_stays_so_and_what_is_stays_so() -> None:
    stand_ins = StandIns()
    with pytest.raises(UnicodeDecodeError):
        stand_ins["Größe".encode("latin-1")].decode()
    assert not stand_ins["左足".encode()].decode().isascii()


def test_names_that_differ_in_case_alone_still_do() -> None:
    stand_ins = StandIns()
    lower, title, upper = (stand_ins[name] for name in (b"chest", b"Chest", b"CHEST"))
    assert lower.lower() == title.lower() == upper.lower()
    assert len({lower, title, upper}) == 3


def test_known_parts_of_a_word_stay() -> None:
    stand_ins = StandIns()
    masked = stand_ins.in_words(b"AnnFoot_deg,AnnHandX", frozenset((b"deg", b"x")), by_parts=True)
    foot, hand = masked.split(b",")
    assert foot.endswith(b"_deg")
    assert hand.endswith(b"X")
    assert foot[:3] == hand[:3] != b"Ann"
    assert stand_ins.stayed == {b"deg", b"X"}


def test_a_name_that_was_met_goes_from_among_numbers_too() -> None:
    stand_ins = StandIns()
    masked = stand_ins.in_words(b"Annabel Bo")
    swept = stand_ins.swept(b"\x00\x01Annabel\xffBo\x02")
    assert swept == b"\x00\x01" + masked[:7] + b"\xffBo\x02"


def test_messages_are_alike_but_for_names_and_nothing_else() -> None:
    pairs = {b"LeftFoot": b"N0000000", b"Hips": b"N000"}
    ours = "clip.bvh:12: 'LeftFoot' of 'Hips': 3 values"
    assert alike(ours, "clip.bvh:12: 'N0000000' of 'N000': 3 values", pairs)
    assert not alike(ours, "clip.bvh:12: 'N000' of 'N0000000': 3 values", pairs)
    assert not alike(ours, "clip.bvh:13: 'N0000000' of 'N000': 3 values", pairs)
    assert alike(ours, "clip.bvh:13: 'N0000000' of 'N000': 3 values", pairs, numbers_too=False)
    assert not alike(ours, "clip.bvh:12: 'N0000000' of 'N000': 3 numbers", pairs, numbers_too=False)
    # A message that is cut short may end within a name.
    assert alike("found 'LeftF...'", "found 'N0000...'", pairs)


def test_the_words_of_a_reader_are_those_of_its_code() -> None:
    words = words_of_modules("retime.formats.tables")
    assert {b"scorer", b"bodyparts", b"endheader"} <= words
    assert not {b"hips", b"leftfoot", b"returns"} & words
    with pytest.raises(ValueError, match="no module"):
        words_of_modules("retime.formats.none_such")
