"""Mutants of other programs' retime curves: each is read as a warp that can be saved, or refused."""

from __future__ import annotations

import functools
import random
import re
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.hosts.exporting import export_curve
from retime.hosts.registry import HOSTS, Host
from retime.hosts.shot import Shot
from retime.warp.curve import Warp
from tests.fuzz.trials import Trial, mutated_text

_WARP = Warp([0.0, 0.5, 1.0, 1.5, 2.25], [0.0, 1.0, 1.0, 0.25, 3.0])
_ODD = [
    *(b"nan", b"inf", b"-1", b"0", b"1e400", b"1e99", b"99999999999999999999", b"1_0", b".5", b"-", b"", b" ", b"\n"),
    *(b"\x00", b"\xff", b'"', b"{", b"}", b"[", b"]", b"<", b">", b"&a;", b"]]>", b"//", b";", b"null", b"true", b"x1"),
    *(
        b"L",
        b"K",
        b"s1",
        b"0/0s",
        b"1/3s",
        b"yes",
        b"[0:9999999]",
        b".ktv[3]",
        b'"h": 1,',
        b"<!DOCTYPE a [",
        b"smooth2",
    ),
]
_TOKEN = re.compile(rb"[A-Za-z_.]+|[-+]?[0-9][0-9.e]*|\s+|.", re.DOTALL)
# What an export of ours does not have: tangents, handles, names, headers of other programs.
_MORE = {
    "maya": [
        b'//Maya ASCII 2024 scene\ncurrentUnit -l centimeter -a degree -t pal;\ncreateNode animCurveTT -n "w";\n'
        b'\tsetAttr ".tan" 1;\n\tsetAttr ".wgt" no;\n\tsetAttr -s 3 ".ktv[0:2]"  1 1 26 51 51 51;\n'
        b'\tsetAttr -s 3 ".kit[0:2]" 2 3 1;\n\tsetAttr -s 3 ".kot[0:2]" 1 3 2;\n\tsetAttr -s 3 ".kix[0:2]" 1 1 0.8;\n'
        b'\tsetAttr -s 3 ".kiy[0:2]" 0 0 0.6;\n\tsetAttr -s 3 ".kox[0:2]" 0.4 1 1;\n'
        b'\tsetAttr -s 3 ".koy[0:2]" 0.9 0 0;\n'
    ],
    "lottie": [
        b'{"fr": 24, "layers": [{"nm": "a", "tm": {"a": 1, "k": [{"t": 0, "s": [0], "o": {"x": [0.4], "y": [0]}, '
        b'"i": {"x": [0.6], "y": [1]}}, {"t": 24, "s": [2], "h": 1}, {"t": 48, "s": [2]}]}}], "assets": []}'
    ],
    "nuke": [b"TimeWarp {\n lookup {{curve x1 1 x2 1.5 2 L x9 4 s2 u1 k 8}}\n name A\n}\n"],
    "csv": [b"output_frame;input_frame\n1;1\n5;9\n9;9\n"],
}


@functools.cache
def whole_files(host: Host) -> tuple[bytes, ...]:
    """Return whole curves of a host."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, f"a{host.suffixes[0]}")
        export_curve(_WARP, place, host.name, rate=8)
        return place.read_bytes(), *_MORE.get(host.name, ())


def mutant(draw: random.Random, whole: tuple[bytes, ...]) -> bytes:
    """Make one: words exchanged, doubled, taken away or made odd; lines, stretches and bytes of it changed."""
    data = draw.choice(whole)
    if draw.random() < 0.4:
        return mutated_text(draw, data, _ODD, whole)
    words = _TOKEN.findall(data)
    for _ in range(draw.choice([0, 1, 1, 1, 2, 2, 3, 6])):
        first, last = sorted((draw.randrange(len(words)), draw.randrange(len(words))))
        kind = draw.randrange(6)
        if kind == 0:
            words[first] = draw.choice(_ODD)
        elif kind == 1:
            words[last] = words[first]
        elif kind == 2:
            del words[first]
        elif kind == 3:
            words[last:last] = words[first:last]
        elif kind == 4:
            del words[first : min(last, first + 20)]
        else:
            words.insert(first, draw.choice(_ODD))
        words = words or [b" "]
    return b"".join(words)


def curve_file(draw: random.Random, host: Host) -> str:
    """Read a mutant of a host's curve; what comes of it can be saved and read again."""
    data = mutant(draw, whole_files(host))
    warp = host.module.read(data, Shot(Fraction(8), 1, "", 0.01))
    assert np.isfinite(warp.output_times).all()
    assert np.isfinite(warp.input_times).all()
    assert Warp.from_json(warp.to_json()) == warp
    return f"a curve of {host.name} is read"


KINDS: dict[str, Trial] = {
    f"curve-{host.name}": functools.partial(curve_file, host=host) for host in HOSTS if host.imports
}
