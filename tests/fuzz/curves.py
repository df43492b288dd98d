"""Mutants of other programs' retime curves: each is read as a warp, or refused as FormatError or OptionError.

python -m tests.fuzz.curves --count 100000
"""

from __future__ import annotations

import argparse
import re
import tempfile
import time
import warnings
from collections import Counter
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.errors import FormatError, OptionError, RetimeWarning
from retime.hosts.exporting import export_curve
from retime.hosts.registry import HOSTS, Host
from retime.hosts.shot import Shot
from retime.warp.curve import Warp

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


def seeds() -> dict[Host, list[bytes]]:
    """Return whole curves of each host that is read."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for host in HOSTS:
            if host.imports:
                place = Path(folder, f"a{host.suffixes[0]}")
                export_curve(_WARP, place, host.name, rate=8)
                found[host] = [place.read_bytes(), *_MORE.get(host.name, [])]
                place.unlink()
    return found


def mutant(rng: np.random.Generator, whole: list[bytes]) -> bytes:
    """Make one: words exchanged, doubled, taken away or made odd, bytes turned, the end cut off."""
    words = _TOKEN.findall(whole[rng.integers(len(whole))])
    for _ in range(int(rng.choice([0, 1, 1, 1, 2, 2, 3, 6]))):
        place = int(rng.integers(len(words)))
        other = int(rng.integers(len(words)))
        kind = rng.integers(6)
        if kind == 0:
            words[place] = _ODD[rng.integers(len(_ODD))]
        elif kind == 1:
            words[place] = words[other]
        elif kind == 2:
            words[place : place + 1] = []
        elif kind == 3:
            first, last = sorted((place, other))
            words[last:last] = words[first:last]
        elif kind == 4:
            first, last = sorted((place, other))
            del words[first : min(last, first + 20)]
        else:
            words.insert(place, _ODD[rng.integers(len(_ODD))])
        words = words or [b" "]
    data = bytearray(b"".join(words))
    if data and rng.random() < 0.1:
        data[rng.integers(len(data))] = rng.integers(256)
    if rng.random() < 0.05:
        del data[int(rng.integers(len(data) + 1)) :]
    return bytes(data)


def run(count: int, seed: int = 0) -> Counter[str]:
    """Try mutants; return how many were read and refused. What else happens is raised with its text."""
    rng = np.random.default_rng(seed)
    hosts = list(seeds().items())
    outcomes: Counter[str] = Counter()
    for number in range(count):
        host, whole = hosts[number % len(hosts)]
        data = mutant(rng, whole)
        shot = Shot(Fraction(8), 1, "", 0.01)
        begun = time.monotonic()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RetimeWarning)
                warp = host.module.read(data, shot)
            # It is one that can be saved and read again.
            assert Warp.from_json(warp.to_json()) == warp
            outcomes["read"] += 1
        except (FormatError, OptionError):
            outcomes["refused"] += 1
        except Exception as error:
            raise AssertionError(f"seed {seed}, mutant {number} of {host.name}: {data!r}") from error
        assert time.monotonic() - begun < 10, f"seed {seed}, mutant {number} of {host.name} took long"
    return outcomes


def main() -> None:
    """Run from a shell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    print(dict(run(given.count, given.seed)))


if __name__ == "__main__":
    main()
