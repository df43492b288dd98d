"""C3D files made for tests, byte by byte: every machine, 16-bit and real numbers, analog, events, missing points."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

INTEL, DEC, SGI = 84, 85, 86
FORMS = [(machine, real) for machine in (INTEL, DEC, SGI) for real in (False, True)]


def real_bytes(machine: int, value: float) -> bytes:
    """One real number of a machine; DEC's by the words of its manual: a quarter of the IEEE number, halves swapped."""
    if machine == SGI:
        return struct.pack(">f", value)
    if machine == INTEL:
        return struct.pack("<f", value)
    upper, lower = struct.unpack(">HH", struct.pack(">f", value * 4))
    return struct.pack("<HH", upper, lower)


def word_bytes(machine: int, value: int) -> bytes:
    return struct.pack(">H" if machine == SGI else "<H", value & 0xFFFF)


@dataclass
class Capture:
    """What a file is to hold; values are as stored, before any scale."""

    machine: int = INTEL
    real: bool = True
    scale: float = 0.1
    rate: float = 100.0
    first: int = 1
    points: np.ndarray = field(default_factory=lambda: np.zeros((4, 1, 4)))
    analog: np.ndarray = field(default_factory=lambda: np.zeros((4, 0)))
    labels: Sequence[str] = ()
    analog_labels: Sequence[str] = ()
    offsets: Sequence[int] = ()
    scales: Sequence[float] = ()
    unsigned: bool = False
    events: Sequence[tuple[float, str, str]] = ()
    minutes: bool = False
    header_events: Sequence[tuple[float, str]] = ()
    trial: bool = True
    frames_as: str = "word"
    zero: tuple[int, int] | None = None
    more: dict[str, list[tuple[str, int, list[int], bytes]]] = field(default_factory=dict)

    @property
    def n_frames(self) -> int:
        return len(self.points)

    @property
    def samples(self) -> int:
        return max(len(self.analog) // self.n_frames, 1)

    def groups(self, start: int) -> dict[str, list[tuple[str, int, list[int], bytes]]]:
        """Parameters: name, kind, dimensions, data."""
        n_points, n_channels = self.points.shape[1], self.analog.shape[1]

        def word(name: str, value: int) -> tuple[str, int, list[int], bytes]:
            return name, 2, [], word_bytes(self.machine, value)

        def real(name: str, value: float) -> tuple[str, int, list[int], bytes]:
            return name, 4, [], real_bytes(self.machine, value)

        def texts(name: str, items: Sequence[str]) -> tuple[str, int, list[int], bytes]:
            size = max([len(item.encode()) for item in items], default=1) or 1
            return name, -1, [size, len(items)], b"".join(item.encode().ljust(size) for item in items)

        def many(name: str, kind: int, values: Sequence[float]) -> tuple[str, int, list[int], bytes]:
            store = real_bytes if kind == 4 else word_bytes
            return name, kind, [len(values)], b"".join(store(self.machine, value) for value in values)

        last = self.first + self.n_frames - 1
        labels = list(self.labels) or [f"P{i}" for i in range(n_points)]
        found = {
            "POINT": [
                word("USED", n_points),
                real("SCALE", -self.scale if self.real else self.scale),
                real("RATE", self.rate),
                word("DATA_START", start),
                real("FRAMES", self.n_frames)
                if self.frames_as == "real"
                else word("FRAMES", min(self.n_frames, 65535)),
                texts("LABELS", labels),
                texts("UNITS", ["mm"]),
            ],
            "ANALOG": [word("USED", n_channels), real("RATE", self.rate * self.samples), real("GEN_SCALE", 0.5)],
        }
        if n_channels:
            names = list(self.analog_labels) or [f"ch{i}" for i in range(n_channels)]
            found["ANALOG"] += [
                texts("LABELS", names),
                many("OFFSET", 2, list(self.offsets) or [0] * n_channels),
                many("SCALE", 4, list(self.scales) or [1.0] * n_channels),
                texts("FORMAT", ["UNSIGNED" if self.unsigned else "SIGNED"]),
            ]
        if self.trial:
            found["TRIAL"] = [
                many("ACTUAL_START_FIELD", 2, [self.first & 0xFFFF, self.first >> 16]),
                many("ACTUAL_END_FIELD", 2, [last & 0xFFFF, last >> 16]),
            ]
        if self.events:
            split = [divmod(time, 60.0) if self.minutes else (0.0, time) for time, _, _ in self.events]
            pairs = b"".join(real_bytes(self.machine, part) for pair in split for part in pair)
            found["EVENT"] = [
                word("USED", len(self.events)),
                texts("LABELS", [label for _, label, _ in self.events]),
                texts("CONTEXTS", [context for _, _, context in self.events]),
                ("TIMES", 4, [2, len(self.events)], pairs),
            ]
        if self.zero:
            found["FORCE_PLATFORM"] = [word("USED", 1), many("ZERO", 2, self.zero)]
        return found | self.more

    def section(self, start: int) -> bytes:
        parts = []
        for number, (group, parameters) in enumerate(self.groups(start).items(), start=1):
            text = f"about {group}".encode()
            parts.append((group, -number, bytes([len(text)]) + text))
            for name, kind, dimensions, data in parameters:
                body = struct.pack("bB", kind, len(dimensions)) + bytes(dimensions) + data + b"\x04what"
                parts.append((name, number, body))
        out = b""
        for name, group, body in parts:
            link = word_bytes(self.machine, 2 + len(body))
            out += struct.pack("bb", len(name), group) + name.encode() + link + body
        out += b"\0\0"
        blocks = -(-(len(out) + 4) // 512)
        return (bytes([1, 0x50, blocks, self.machine]) + out).ljust(512 * blocks, b"\0")

    def frame_bytes(self) -> bytes:
        rows = np.concatenate([self.points.reshape(self.n_frames, -1), self.analog.reshape(self.n_frames, -1)], axis=1)
        if self.real and self.machine != DEC:
            return rows.astype(">f4" if self.machine == SGI else "<f4").tobytes()
        if self.real:
            return b"".join(real_bytes(self.machine, value) for value in rows.ravel().tolist())
        return (rows.astype(np.int64) & 0xFFFF).astype(">u2" if self.machine == SGI else "<u2").tobytes()

    def build(self) -> bytes:
        n_points, n_channels = self.points.shape[1], self.analog.shape[1]
        start = 2 + len(self.section(0)) // 512
        last = self.first + self.n_frames - 1
        head = bytes([2, 0x50])
        for value in (n_points, n_channels * self.samples, self.first, min(last, 65535), 10):
            head += word_bytes(self.machine, value)
        head += real_bytes(self.machine, -self.scale if self.real else self.scale)
        head += word_bytes(self.machine, start) + word_bytes(self.machine, self.samples)
        head += real_bytes(self.machine, self.rate)
        head = bytearray(head.ljust(512, b"\0"))
        if self.header_events:
            head[298:300] = word_bytes(self.machine, 12345)
            head[300:302] = word_bytes(self.machine, len(self.header_events))
            for place, (time, label) in enumerate(self.header_events):
                head[304 + 4 * place : 308 + 4 * place] = real_bytes(self.machine, time)
                head[376 + place] = 1
                head[396 + 4 * place : 400 + 4 * place] = label.encode().ljust(4)
        data = self.frame_bytes()
        return bytes(head) + self.section(start) + data + b"\0" * (-len(data) % 512)


def drawn(seed: int, machine: int | None = None, real: bool | None = None) -> Capture:
    """Draw a capture: smooth markers, some of them missing at times, analog channels, events."""
    rng = np.random.default_rng(seed)
    if machine is None or real is None:
        machine, real = FORMS[int(rng.integers(len(FORMS)))]
    n_frames, n_points = int(rng.integers(3, 40)), int(rng.integers(1, 6))
    samples, n_channels = int(rng.integers(1, 6)), int(rng.integers(0, 4))
    steps = rng.integers(-40, 41, size=(n_frames, n_points, 3))
    places = rng.integers(-2000, 2000, size=(n_points, 3)) + np.cumsum(steps, axis=0)
    points = np.zeros((n_frames, n_points, 4))
    points[..., :3] = places
    points[..., 3] = rng.integers(0, 64, size=(n_frames, n_points)) * 256 + rng.integers(0, 30, (n_frames, n_points))
    for point in range(n_points):
        if rng.random() < 0.5:
            start = int(rng.integers(0, n_frames))
            stop = min(start + int(rng.integers(1, 6)), n_frames)
            if stop - start < n_frames:
                points[start:stop, point] = (0, 0, 0, -1)
    unsigned = bool(rng.random() < 0.5) and not real
    analog = rng.integers(0 if unsigned else -3000, 60_000 if unsigned else 3000, (n_frames * samples, n_channels))
    rate = float(rng.choice([50.0, 62.5, 100.0, 120.0, 250.0]))
    first = int(rng.choice([1, 1, 7, 500]))
    times = sorted((first - 1 + rng.uniform(0, n_frames - 1, int(rng.integers(0, 5)))) / rate)
    events = [(float(time), str(rng.choice(["Foot Strike", "Foot Off"])), "Left") for time in times]
    return Capture(
        machine=machine,
        real=real,
        scale=float(rng.choice([0.1, 0.0625, 1.0])),
        rate=rate,
        first=first,
        points=points,
        analog=analog.astype(np.float64),
        offsets=rng.integers(0, 3000, n_channels).tolist(),
        scales=rng.uniform(0.1, 2.0, n_channels).astype(np.float32).tolist(),
        unsigned=unsigned,
        events=events,
        header_events=[(time - (first - 1) / rate, "EV") for time, _, _ in events[:3]],
        trial=bool(rng.random() < 0.7),
        zero=(1, min(3, n_frames)) if rng.random() < 0.5 else None,
    )
