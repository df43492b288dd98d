"""USD scenes made by the tests, as text: every kind of value, odd clocks and names, and words that must stay."""

from __future__ import annotations

import numpy as np


def numbers(row: np.ndarray) -> str:
    """A tuple, or one number, in single precision."""
    row = np.atleast_1d(row)
    text = ", ".join(repr(float(np.float32(number))) for number in row)
    return f"({text})" if len(row) > 1 else text


def quaternions(rng: np.random.Generator, n: int) -> np.ndarray:
    rows = rng.normal(size=(n, 4))
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def samples(kind: str, name: str, times: np.ndarray, texts: list[str], margin: str = "        ") -> str:
    lines = "".join(f"{margin}    {float(time)!r}: {text},\n" for time, text in zip(times, texts, strict=True))
    return f"{margin}{kind} {name}.timeSamples = {{\n{lines}{margin}}}\n"


class DrawnScene:
    """A skeleton, a prim that moves, and values of many kinds, on a clock of its own."""

    def __init__(self, seed: int, *, authored: bool = True) -> None:
        rng = np.random.default_rng(seed)
        self.rng = rng
        self.per_second = float(rng.choice([24, 25, 30, 60, 1, 1000, 23.976]))
        self.start = float(rng.choice([0, 1, -12, 101]))
        self.length = self.per_second * float(rng.uniform(0.8, 2.5))
        self.end = self.start + self.length
        self.n_joints = int(rng.integers(1, 6))
        self.names = [f"j{rng.integers(1000)}_{i}" for i in range(self.n_joints)]
        self.authored = authored

    def times(self, n: int) -> np.ndarray:
        inner = np.sort(self.rng.uniform(self.start, self.end, n - 2))
        return np.concatenate([[self.start], inner, [self.end]])

    def arrays(self, kind: str, name: str, n: int, rows) -> str:
        texts = ["[" + ", ".join(numbers(row) for row in rows()) + "]" for _ in range(n)]
        return samples(kind, name, self.times(n), texts, "            ")

    def skeleton(self) -> str:
        rng, n = self.rng, self.n_joints
        tokens: list[str] = []
        for joint, name in enumerate(self.names):
            parent = int(rng.integers(joint)) if joint else -1
            tokens.append(name if parent < 0 else f"{tokens[parent]}/{name}")
        order = ", ".join(f'"{token}"' for token in tokens)
        rest = []
        for _ in range(n):
            x, y, z = rng.normal(size=3).round(3)
            rest.append(f"((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), ({x}, {y}, {z}, 1))")
        moved = self.arrays("float3[]", "translations", 5, lambda: rng.normal(size=(n, 3)))
        turned = self.arrays("quatf[]", "rotations", 7, lambda: quaternions(rng, n))
        weights = self.arrays("float[]", "blendShapeWeights", 4, lambda: rng.uniform(size=2))
        return f"""
def SkelRoot "Body" (
    prepend apiSchemas = ["SkelBindingAPI"]
    customData = {{
        string note = "kept {{ as it is"
    }}
)
{{
    # A comment of whoever made it.
    def Skeleton "Skel" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform token[] joints = [{order}]
        uniform matrix4d[] bindTransforms = [{", ".join(rest)}]
        uniform matrix4d[] restTransforms = [{", ".join(rest)}]
        rel skel:animationSource = </Body/Skel/Anim>

        def SkelAnimation "Anim"
        {{
            uniform token[] joints = [{order}]
            uniform token[] blendShapes = ["smile", "frown"]
            half3[] scales = [{", ".join(["(1, 1, 1)"] * n)}]
{moved}{turned}{weights}        }}
    }}
}}
"""

    def prop(self) -> str:
        rng = self.rng
        words = [f'"{word}"' for word in rng.permutation(["a", "b", "c", "d"])]
        grown = ["[" + ", ".join(numbers(x) for x in rng.normal(size=n)) + "]" for n in (3, 3, 2, 2, 2, 3)]
        blocked = [numbers(x) for x in rng.normal(size=5)]
        blocked[2] = "None"
        parts = [
            samples("double3", "xformOp:translate", self.times(4), [numbers(x) for x in rng.normal(size=(4, 3))]),
            samples("quatf", "xformOp:orient", self.times(3), [numbers(x) for x in quaternions(rng, 3)]),
            samples("token", "visibility", self.times(2), ['"inherited"', '"invisible"']),
            samples("custom string", "word", self.times(4), words),
            samples("custom int", "count", self.times(5), [str(x) for x in rng.integers(100, size=5)]),
            samples("custom bool", "on", self.times(3), ["0", "1", "0"]),
            samples("custom double[]", "grown", self.times(6), grown),
            samples("custom float", "blocked", self.times(5), blocked),
            samples("custom double", "alone", np.array([self.start + 1]), ["7"]),
        ]
        return (
            'def Xform "Prop"\n{\n    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]\n'
            + "".join(parts)
            + '    custom string note = "timeSamples = { 1: 2 }"\n}\n'
        )

    def text(self) -> str:
        clock = f"    startTimeCode = {self.start!r}\n    endTimeCode = {self.end!r}\n" if self.authored else ""
        return (
            f'#usda 1.0\n(\n    "A scene of the tests"\n{clock}    timeCodesPerSecond = {self.per_second!r}\n'
            f'    upAxis = "Z"\n    metersPerUnit = 0.01\n)\n{self.skeleton()}\n{self.prop()}'
        )
