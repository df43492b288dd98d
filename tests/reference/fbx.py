"""FBX animation, literally: `struct` and plain numbers, one value at a time; a Bézier curve is solved by halving."""

from __future__ import annotations

import bisect
import math
import re
import struct
import zlib

TICKS = 46_186_158_000
CODES = {"f": "f", "d": "d", "l": "q", "i": "i"}


class Scene:
    """What a file holds: its records, and its curves by number."""

    def __init__(self, data: bytes) -> None:
        if data.startswith(b"Kaydara"):
            self.version = struct.unpack_from("<I", data, 23)[0]
            self.records = self._binary(data)
        else:
            self.version = int(re.search(rb"FBXVersion: (\d+)", data)[1])
            self.records = self._text(data.decode())
        objects = next(inner for name, _, inner in self.records if name == "Objects")
        self.curves = {}
        for name, values, inner in objects:
            if name == "AnimationCurve":
                arrays = {child: given[0] for child, given, _ in inner if child.startswith("Key") and child != "KeyVer"}
                beyond = {child: within for child, _, within in inner if child.endswith("Extrapolation")}
                self.curves[values[0]] = Curve(arrays, beyond)

    def _binary(self, data):
        head = "<QQQB" if self.version >= 7500 else "<IIIB"
        size = struct.calcsize(head)

        def read(place):
            end, n, _, name_size = struct.unpack_from(head, data, place)
            if not end:
                return None, place + size
            place += size
            name = data[place : place + name_size].decode()
            place += name_size
            values = []
            for _ in range(n):
                letter = chr(data[place])
                place += 1
                if letter in CODES:
                    count, packed, length = struct.unpack_from("<III", data, place)
                    raw = data[place + 12 : place + 12 + length]
                    raw = zlib.decompress(raw) if packed else raw
                    if name == "KeyAttrDataFloat":
                        letter = "i"
                    values.append(list(struct.unpack(f"<{count}{CODES[letter]}", raw)))
                    place += 12 + length
                elif letter in "SR":
                    length = struct.unpack_from("<I", data, place)[0]
                    values.append(data[place + 4 : place + 4 + length])
                    place += 4 + length
                else:
                    code = {"I": "<i", "L": "<q", "D": "<d", "C": "<B", "F": "<f", "Y": "<h"}[letter]
                    values.append(struct.unpack_from(code, data, place)[0])
                    place += struct.calcsize(code)
            inner = []
            while place < end:
                child, place = read(place)
                if child is not None:
                    inner.append(child)
            assert place == end
            return (name, values, inner), end

        place, records = 27, []
        while True:
            record, place = read(place)
            if record is None:
                break
            records.append(record)
        foot = data[place:]
        assert foot.endswith(bytes.fromhex("f85a8c6adef5d97eece90ce3758f290b"))
        assert struct.unpack_from("<I", foot, len(foot) - 140)[0] == self.version
        return records

    def _text(self, text):
        text = re.sub(r"^\s*;.*$", "", text, flags=re.MULTILINE)
        tokens = re.findall(r'"[^"]*"|[{}]|[\w|-]+:(?=[\s"*])|[^\s,{}"]+', text)
        place = 0

        def body():
            nonlocal place
            records = []
            while place < len(tokens) and tokens[place] != "}":
                name = tokens[place].rstrip(":")
                place += 1
                values, inner = [], []
                while place < len(tokens) and not re.fullmatch(r"[{}]|[A-Za-z][\w|-]*:", tokens[place]):
                    values.append(tokens[place])
                    place += 1
                if place < len(tokens) and tokens[place] == "{":
                    place += 1
                    inner = body()
                    assert tokens[place] == "}"
                    place += 1
                if values and values[0].startswith("*"):
                    numbers = [float(x) if re.search(r"[.e]", str(x)) else int(x) for x in inner[0][1]]
                    assert len(numbers) == int(values[0][1:])
                    if name == "KeyAttrDataFloat" and self.version < 7200:
                        numbers = [struct.unpack("<i", struct.pack("<f", x))[0] for x in numbers]
                    values, inner = [numbers], []
                else:
                    values = [
                        x[1:-1].encode() if x.startswith('"') else int(x) if re.fullmatch(r"-?\d+", x) else x
                        for x in values
                    ]
                records.append((name, values, inner))
            return records

        return body()


class Curve:
    """A curve, key by key."""

    def __init__(self, arrays, beyond) -> None:
        self.ticks = arrays["KeyTime"]
        self.times = [tick / TICKS for tick in self.ticks]
        self.values = [float(value) for value in arrays["KeyValueFloat"]]
        self.flags, self.data = [], []
        for run, count in enumerate(arrays["KeyAttrRefCount"]):
            self.flags += [arrays["KeyAttrFlags"][run]] * count
            self.data += [arrays["KeyAttrDataFloat"][4 * run : 4 * run + 4]] * count
        assert len(self.flags) == len(self.values) == len(self.times)
        assert all(a < b for a, b in zip(self.ticks[:-1], self.ticks[1:], strict=True))
        self.pre, self.post = (_extrapolation(beyond.get(name)) for name in ("Pre-Extrapolation", "Post-Extrapolation"))
        self.right, self.left, self.right_weight, self.left_weight = self._slopes()

    def _number(self, key, place):
        return struct.unpack("<f", struct.pack("<i", self.data[key][place]))[0]

    def _slopes(self):
        n = len(self.times)
        right, left = [0.0] * n, [0.0] * n
        right_weight, left_weight = [1 / 3] * n, [1 / 3] * n
        arriving, arriving_weight = 0.0, 1 / 3
        for key in range(n):
            flags = self.flags[key]
            before = after = None
            if key:
                before = (self.values[key] - self.values[key - 1]) / (self.times[key] - self.times[key - 1])
            if key + 1 < n:
                after = (self.values[key + 1] - self.values[key]) / (self.times[key + 1] - self.times[key])
            left[key], left_weight[key] = arriving, arriving_weight
            arriving, arriving_weight = self._number(key, 1), 1 / 3
            packed = self.data[key][2] & 0xFFFFFFFF
            if flags & 0x2:
                arriving = 0.0
            elif flags & 0x8 and flags & 0x200:
                tension, continuity, bias = (self._number(key, place) for place in range(3))
                factor = (0.5 if before is not None and after is not None else 1.0) * (1 - tension)
                one, two = before or 0.0, after or 0.0
                if flags & 0x1000000:
                    right_weight[key] = (packed & 0xFFFF) / 10_000
                left[key] = factor * ((1 + bias) * (1 - continuity) * one + (1 - bias) * (1 + continuity) * two)
                right[key] = factor * ((1 + bias) * (1 + continuity) * one + (1 - bias) * (1 - continuity) * two)
                arriving = 0.0
            elif flags & 0x8:
                right[key] = self._number(key, 0)
                if flags & 0x1000000:
                    right_weight[key] = (packed & 0xFFFF) / 10_000
                if flags & 0x2000000:
                    arriving_weight = (packed >> 16) / 10_000
                if not flags & 0x400:
                    right[key], left[key] = self._automatic(key, before, after, left[key], left_weight, right_weight)
            else:
                right[key] = arriving = after or 0.0
        return right, left, right_weight, left_weight

    def _automatic(self, key, before, after, left_number, left_weight, right_weight):
        flags = self.flags[key]
        right_bias, left_bias = self._number(key, 0), -left_number
        if before is None and after is None:
            return 0.0, 0.0
        if before is None or after is None:
            rise = self.values[key] - self.values[key - 1] if after is None else self.values[key + 1] - self.values[key]
            if flags & 0x4000 or (flags & 0x1000 and rise == 0):
                return 0.0, 0.0
            slope = before if after is None else after
            return slope, slope
        if abs(right_bias - left_bias) <= 1e-4:
            left_bias = right_bias
        found = []
        for bias in (right_bias, left_bias):
            low, high = self.values[key] - self.values[key - 1], self.values[key + 1] - self.values[key]
            first, second = self.times[key] - self.times[key - 1], self.times[key + 1] - self.times[key]
            slope = (low + high) / (first + second)
            if not flags & 0x2000:
                share = first / (first + second)
                slope = slope / 2 + (before * (1 - share) + after * share) / 2
                if abs(bias) > 0.01:
                    slope += ((after if bias > 0 else before) - slope) * abs(bias) / 100
            if flags & 0x4000:
                for rise, room in ((low, first * left_weight[key]), (high, second * right_weight[key])):
                    most = max(rise * (1 if slope >= 0 else -1) / room, 0.0) if room else 0.0
                    slope = max(-most, min(most, slope))
            if flags & 0x1000 and not (low and high):
                slope = 0.0
            found.append(slope)
        return found[0], found[1]

    def value(self, time: float) -> float:
        """What the curve has at a time."""
        first, last = self.times[0], self.times[-1]
        if len(self.times) == 1:
            return self.values[0]
        if first <= time <= last:
            return self._within(time)
        (mode, count), edge = (self.pre, first) if time < first else (self.post, last)
        at, slope = (self.values[0], self.right[0]) if time < first else (self.values[-1], self.left[-1])
        if mode == "K":
            return at + slope * (time - edge)
        if mode == "C" or count == 0:
            return at
        length = last - first
        turns, over = divmod(abs(time - edge), length)
        if 0 < count <= turns:
            turns, over = count - 1, length
        if mode == "M" and turns % 2 == 0:
            over = length - over
        inside = last - over if time < first else first + over
        value = self._within(min(max(inside, first), last))
        if mode == "A":
            value += (turns + 1) * (self.values[-1] - self.values[0]) * (-1 if time < first else 1)
        return value

    def _within(self, time: float) -> float:
        key = bisect.bisect_right(self.times, time) - 1
        if self.times[key] == time:
            return self.values[key]
        start, end = self.times[key], self.times[key + 1]
        a, b = self.values[key], self.values[key + 1]
        flags, width = self.flags[key], end - start
        if flags & 0x2:
            return b if flags & 0x100 else a
        if not flags & 0x8:
            return a + (b - a) * (time - start) / width
        out, into = min(self.right_weight[key], 1.0), min(self.left_weight[key + 1], 1.0)
        across = [0.0, out, 1 - into, 1.0]
        up = [a, a + self.right[key] * out * width, b - self.left[key + 1] * into * width, b]
        low, high = 0.0, 1.0
        for _ in range(100):
            middle = (low + high) / 2
            low, high = (middle, high) if _bezier(across, middle) <= (time - start) / width else (low, middle)
        return _bezier(up, low)


def _bezier(p, u):
    return (1 - u) ** 3 * p[0] + 3 * (1 - u) ** 2 * u * p[1] + 3 * (1 - u) * u**2 * p[2] + u**3 * p[3]


def _extrapolation(records):
    if not records:
        return "C", -1
    found = {name: values[0] for name, values, _ in records}
    mode = found["Type"]
    return chr(mode) if isinstance(mode, int) else mode, int(found.get("Repetition", -1))


# Nodes: matrices of three rows and columns as lists, by the formula of FBX's documentation.


def turn(axis: int, degrees: float):
    """A turn about an axis."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    m = [[float(i == j) for j in range(3)] for i in range(3)]
    m[a][a], m[a][b], m[b][a], m[b][b] = c, -s, s, c
    return m


def times(a, b):
    """A product of matrices."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(m, v):
    """A matrix times a vector."""
    return [sum(m[i][k] * v[k] for k in range(3)) for i in range(3)]


def euler(degrees, order: str = "XYZ"):
    """A turn about each axis, the first of the order first."""
    m = [[float(i == j) for j in range(3)] for i in range(3)]
    for axis in order:
        m = times(turn("XYZ".index(axis), degrees["XYZ".index(axis)]), m)
    return m


def part_of(m, share: float):
    """A share of a turn, about its own axis."""
    angle = math.acos(max(-1.0, min(1.0, (m[0][0] + m[1][1] + m[2][2] - 1) / 2)))
    if angle < 1e-12:
        return m
    axis = [(m[2][1] - m[1][2]), (m[0][2] - m[2][0]), (m[1][0] - m[0][1])]
    length = math.sqrt(sum(x * x for x in axis))
    x, y, z = (one / length for one in axis)
    k = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    kk = times(k, k)
    s, c = math.sin(share * angle), 1 - math.cos(share * angle)
    return [[float(i == j) + s * k[i][j] + c * kk[i][j] for j in range(3)] for i in range(3)]


def node_pose(turned, props: dict):
    """A node's turn and the place of its origin, from its own turn and its properties."""
    post = euler(props.get("PostRotation", [0.0] * 3))
    whole = times(
        times(euler(props.get("PreRotation", [0.0] * 3)), turned), [list(row) for row in zip(*post, strict=True)]
    )
    v = [0.0, 0.0, 0.0]
    pivot, scaling_pivot = props.get("RotationPivot", [0.0] * 3), props.get("ScalingPivot", [0.0] * 3)
    v = [s * (x - p) + p for x, s, p in zip(v, props["Lcl Scaling"], scaling_pivot, strict=True)]
    v = [x + o - p for x, o, p in zip(v, props.get("ScalingOffset", [0.0] * 3), pivot, strict=True)]
    v = apply(whole, v)
    offset = props.get("RotationOffset", [0.0] * 3)
    return whole, [x + p + o + t for x, p, o, t in zip(v, pivot, offset, props["Lcl Translation"], strict=True)]
