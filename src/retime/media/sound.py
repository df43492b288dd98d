"""Sound by a warp: stretched piece by piece with its pitch kept, or resampled.

What begins suddenly (a click, a step, a consonant) is taken out before, and laid down as it is at its moment after, so
that stretching doesn't smear it. A piece at the input's own speed is copied. Time that stands, or all but stands, is
filled with the room's own tone; time that runs backward plays backward.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from retime.media.extras import needed
from retime.media.pieces import SHORTEST, Piece, pieces_of
from retime.warp.curve import Warp

Samples = NDArray[np.float32]

ReadSamples = Callable[[int, int], Samples]
"""Takes the first sample and how many; returns (n_channels, count), silence where there is none."""

# Seconds of output that are made at a time.
_BLOCK = 10.0
# Half of the span in which two pieces are faded into each other, and how long sound fades into a hold.
_FADE, _HOLD_FADE = 0.004, 0.05
# Of what begins suddenly, seconds before and after its beginning that are taken out.
_BEFORE, _AFTER = 0.012, 0.035
# What is resampled has no pitch to be heard: its pieces may be as short as the fades between them allow.
_SHORTEST_RESAMPLED = 0.02
# Seconds of input beyond a piece's ends that are stretched with it: alone, it would fade there.
_MARGIN = 0.12
# A beginning is so many times as loud as what was before (in energy), in such a share of all bands, and not much softer
# than the rest.
_RISE, _BANDS, _FLOOR = 4.0, 0.3, 1e-2
_SAME = 1e-4


def sound_length(warp: Warp, rate: int, tail: float = 0.0) -> int:
    """Count the samples of an output."""
    return max(1, round((warp.output_span + tail) * rate))


def retimed_sound(
    read: ReadSamples, n_channels: int, rate: int, warp: Warp, *, keep_pitch: bool, tail: float = 0.0
) -> Iterator[Samples]:
    """Give sound a warp's timing.

    Parameters
    ----------
    read : function
        Gives samples of the input; sample 0 is at the warp's input time 0.
    n_channels, rate : int
        Channels and samples a second.
    warp : Warp
        From output time to input time.
    keep_pitch : bool
        Stretch; otherwise resample, so that pitch follows speed.
    tail : float
        Seconds for which the sound goes on after the warp's end, at its own speed.

    Yields
    ------
    float32 array, shape (n_channels, n)
        One after the other; `sound_length` in all.
    """
    pieces = pieces_of(warp, SHORTEST if keep_pitch else _SHORTEST_RESAMPLED)
    if tail > 0:
        last = pieces[-1]
        way = 0.0 if last.speed == 0 else float(np.sign(last.speed))
        pieces.append(Piece(last.output_end, last.output_end + tail, last.input_end, last.input_end + way * tail))
    start = warp.output_start
    total = sound_length(warp, rate, tail)
    sound = _Sound(read, n_channels, rate, warp, keep_pitch)
    fade = max(2, round(_FADE * rate))
    blocks = [block for piece in pieces for block in _blocks(piece)]
    yield from _overlaid(_steady(sound, blocks, start, total, fade), sound.sudden, round(_BEFORE * rate) + 4 * fade)


def _steady(sound: _Sound, blocks: list[Piece], start: float, total: int, fade: int) -> Iterator[Samples]:
    """Make one piece after another, each faded into the next."""
    rate = sound.rate
    # What reaches over the last piece's end.
    left: Samples | None = None
    first = 0
    for number, piece in enumerate(blocks):
        stop = total if number == len(blocks) - 1 else round((piece.output_end - start) * rate)
        before, after = (fade if left is not None else 0), (fade if number < len(blocks) - 1 else 0)
        # The input's place (in samples) at the first sample asked for.
        begin = piece.input_start + ((first - before) / rate + start - piece.output_start) * piece.speed
        stretched = after and sound.stretches(blocks[number + 1])
        span = _Span(first - before, first, stop, stop + after, None if stretched else stop + after)
        made = sound.make(piece, begin * rate, span, left)
        if left is not None:
            made[:, : 2 * fade] = _crossed(left, made[:, : 2 * fade])
        kept = made.shape[1] - (2 * fade if after else 0)
        yield made[:, :kept]
        left = made[:, kept:] if after else None
        first = stop


class _Span(NamedTuple):
    """Samples of the output that are made at a time.

    Attributes
    ----------
    begin, end : int
        With what is faded into the neighbours.
    first, stop : int
        Without.
    last : int, optional
        Where the sound that follows has in it what begins suddenly before.
    """

    begin: int
    first: int
    stop: int
    end: int
    last: int | None

    @property
    def length(self) -> int:
        """Return how many there are."""
        return self.end - self.begin


def _overlaid(blocks: Iterator[Samples], sudden: list[tuple[int, Samples]], held_back: int) -> Iterator[Samples]:
    """Add sounds at their places to what comes block by block; `sudden` grows meanwhile."""
    waiting: Samples | None = None
    first = 0
    for block in blocks:
        waiting = block if waiting is None else np.concatenate([waiting, block], axis=1)
        ready = waiting.shape[1] - held_back
        if ready > 0:
            _lay(waiting, first, sudden)
            yield waiting[:, :ready]
            waiting, first = waiting[:, ready:], first + ready
    if waiting is not None:
        _lay(waiting, first, sudden)
        yield waiting


def _lay(block: Samples, first: int, sudden: list[tuple[int, Samples]]) -> None:
    """Add what falls on a block; what reaches beyond it waits for the next."""
    rest = []
    stop = first + block.shape[1]
    for place, sound in sudden:
        low, high = max(place, first), min(place + sound.shape[1], stop)
        if high > low:
            block[:, low - first : high - first] += sound[:, low - place : high - place]
        if place + sound.shape[1] > stop:
            rest.append((max(place, stop), sound[:, max(0, stop - place) :]))
    sudden[:] = rest


def _blocks(piece: Piece) -> Iterator[Piece]:
    """Part a long piece."""
    n = max(1, int(np.ceil((piece.output_end - piece.output_start) / _BLOCK)))
    outputs = np.linspace(piece.output_start, piece.output_end, n + 1).tolist()
    inputs = np.linspace(piece.input_start, piece.input_end, n + 1).tolist()
    for i in range(n):
        yield Piece(outputs[i], outputs[i + 1], inputs[i], inputs[i + 1])


def _crossed(old: Samples, new: Samples) -> Samples:
    """Fade one stretch of sound into another, as loud in the middle as at its ends."""
    share = np.linspace(0, 1, new.shape[1], dtype=np.float32)
    alike = _likeness(old, new)
    # What is alike adds up by amplitude, what is not by energy.
    gain = 1 / np.sqrt((1 - share) ** 2 + share**2 + 2 * share * (1 - share) * max(alike, 0.0))
    return np.asarray(((1 - share) * old + share * new) * gain, np.float32)


def _likeness(old: Samples, new: Samples) -> float:
    """Return the cosine of two stretches of sound; 1 where one is silent."""
    energy = float(np.vdot(old, old)) * float(np.vdot(new, new))
    return float(np.vdot(old, new)) / np.sqrt(energy) if energy > 0 else 1.0


class _Sound:
    """What makes the samples of one piece after another."""

    def __init__(self, read: ReadSamples, n_channels: int, rate: int, warp: Warp, keep_pitch: bool) -> None:
        self._read, self._n_channels, self.rate, self._warp = read, n_channels, rate, warp
        self._keep_pitch = keep_pitch
        # What begins suddenly, with its place in the output, still to be laid down.
        self.sudden: list[tuple[int, Samples]] = []

    def stretches(self, piece: Piece) -> bool:
        """Tell whether a piece is stretched."""
        return self._keep_pitch and not piece.held and abs(abs(piece.speed) - 1) >= _SAME

    def make(self, piece: Piece, begin: float, span: _Span, left: Samples | None) -> Samples:
        """Make samples of a piece from a place of the input (in samples) on; `left` is what they are faded in from."""
        if piece.held:
            return self._held(begin, span.length)
        backward, speed = piece.speed < 0, abs(piece.speed)
        if self.stretches(piece):
            return self._stretched(piece, begin, span, left)
        if abs(speed - 1) < _SAME:
            return self._input(round(begin), span.length, backward)
        return self._resampled(begin, span.length, speed, backward)

    def _input(self, begin: int, count: int, backward: bool) -> Samples:
        """Read on, or back."""
        if backward:
            return np.ascontiguousarray(self._read(begin - count + 1, count)[:, ::-1])
        return self._read(begin, count).copy()

    def _stretched(self, piece: Piece, begin: float, span: _Span, left: Samples | None) -> Samples:
        count, rate, speed, backward = span.length, self.rate, abs(piece.speed), piece.speed < 0
        margin = round(_MARGIN * rate)
        made_margin = round(margin / speed)
        length = round((count + 2 * made_margin) * speed)
        first = round(begin) + margin - length + 1 if backward else round(begin) - margin
        steady, sudden = without_sudden(self._read(first, length).copy(), rate)
        if backward:
            steady = np.ascontiguousarray(steady[:, ::-1])
        for place, start, sound in sudden:
            self._keep(piece, first + place, place - start, sound, span)
        stretch = needed("python_stretch").Signalsmith.Stretch()
        stretch.preset(self._n_channels, rate)
        stretch.setTimeFactor(length / (count + 2 * made_margin))
        made = np.asarray(stretch.process(steady), np.float32)
        lacking = count + 2 * made_margin - made.shape[1]
        if lacking > 0:
            made = np.pad(made, ((0, 0), (0, lacking)))
        slack = min(round(0.003 * rate), made_margin)
        shift = 0
        if left is not None:
            width = left.shape[1]
            fits = [
                _likeness(left, made[:, made_margin + d : made_margin + d + width]) for d in range(-slack, slack + 1)
            ]
            # A little better is not worth being late.
            shift = int(np.argmax(np.array(fits) - 0.05 * np.abs(np.arange(-slack, slack + 1)) / slack)) - slack
        return made[:, made_margin + shift : made_margin + shift + count].copy()

    def _keep(self, piece: Piece, place: int, lead: int, sound: Samples, span: _Span) -> None:
        """Keep a sudden sound for its moment: one at a place of the input, whose samples begin `lead` before."""
        if piece.speed < 0:
            lead, sound = sound.shape[1] - 1 - lead, sound[:, ::-1]
        # Where the warp itself has it, which a piece only follows.
        inner = self._warp.output_times
        times = [
            piece.output_start,
            *inner[(inner > piece.output_start) & (inner < piece.output_end)],
            piece.output_end,
        ]
        values = self._warp(times) if piece.output_end <= self._warp.output_end else np.array(piece[2:])
        order = slice(None, None, -1 if piece.speed < 0 else 1)
        time = place / self.rate
        if not min(piece.input_start, piece.input_end) <= time < max(piece.input_start, piece.input_end):
            # It is its neighbour's.
            return
        moment = span.first + round(
            (float(np.interp(time, values[order], times[order])) - piece.output_start) * self.rate
        )
        sound = sound.copy()
        if span.last is not None and moment - lead + sound.shape[1] > span.last:
            # What follows has its end in it.
            kept = max(1, span.last - moment + lead)
            sound = sound[:, :kept]
            fade = min(kept, round(_FADE * self.rate))
            sound[:, kept - fade :] *= np.linspace(1, 0, fade, dtype=np.float32)
        self.sudden.append((moment - lead, sound))

    def _resampled(self, begin: float, count: int, speed: float, backward: bool) -> Samples:
        """Sample the input between its samples: a sinc with a window, as wide as the speed makes it."""
        places = begin + np.arange(count) * (-speed if backward else speed)
        half = int(np.ceil(16 * max(1.0, speed)))
        low = int(np.floor(places.min())) - half
        sound = self._read(low, int(np.ceil(places.max())) + half + 2 - low)
        made = np.empty((self._n_channels, count), np.float32)
        cut = min(1.0, 1 / speed)
        taps = np.arange(-half + 1, half + 1)
        for at in range(0, count, 1 << 14):
            some = places[at : at + (1 << 14)]
            whole = np.floor(some).astype(np.int64)
            distance = taps[None, :] - (some - whole)[:, None]
            kernel = cut * np.sinc(cut * distance) * np.cos(np.pi / 2 * np.clip(distance / half, -1, 1)) ** 2
            kernel /= kernel.sum(axis=1, keepdims=True)
            rows = whole[:, None] + taps[None, :] - low
            for channel in range(self._n_channels):
                made[channel, at : at + len(some)] = np.einsum("nt,nt->n", kernel, sound[channel][rows])
        return made

    def _held(self, begin: float, count: int) -> Samples:
        """Fade what was heard last, backward, into the tone of the room."""
        made = self._room_tone(round(begin), count)
        fade = min(count, round(_HOLD_FADE * self.rate))
        share = np.linspace(1, 0, fade, dtype=np.float32) ** 2
        last = self._input(round(begin), fade, True)
        made[:, :fade] = share * last + np.sqrt(1 - share**2) * made[:, :fade]
        return made

    def _room_tone(self, place: int, count: int) -> Samples:
        """Return what the room sounds like where nothing happens: the softest quarter of a second near, repeated."""
        rate = self.rate
        length = rate // 4
        around = self._read(place - 5 * rate, 10 * rate)
        n = around.shape[1] // length
        energy = (around[:, : n * length].reshape(self._n_channels, n, length) ** 2).mean(axis=(0, 2))
        # Digital silence lies before the beginning and after the end: it is a room's tone only where nothing else is.
        heard = np.flatnonzero(energy > 0)
        if not len(heard):
            return np.zeros((self._n_channels, count), np.float32)
        soft = int(heard[np.argmin(energy[heard])])
        loud = float(np.percentile(energy[heard], 90))
        if energy[soft] > 0.1 * loud:
            # It is never soft: what goes on all the time is no tone of the room.
            return np.zeros((self._n_channels, count), np.float32)
        tone = around[:, soft * length : (soft + 1) * length]
        return _looped(tone, count)


def _looped(tone: Samples, count: int) -> Samples:
    """Lay parts of a tone over each other, forward and backward, so that no period and no seam is heard."""
    grain = tone.shape[1] // 2
    hop = grain // 2
    # Of noise the energies of neighbours add up, whose windows' squares add up to 1.
    window = np.sin(np.pi * (np.arange(grain) + 0.5) / grain).astype(np.float32)
    chance = np.random.default_rng(0)
    n = count // hop + 3
    made = np.zeros((tone.shape[0], n * hop + grain), np.float32)
    for i in range(n):
        first = int(chance.integers(tone.shape[1] - grain + 1))
        part = tone[:, first : first + grain]
        made[:, i * hop : i * hop + grain] += window * (part[:, ::-1] if i % 2 else part)
    return made[:, hop : hop + count]


def without_sudden(sound: Samples, rate: int) -> tuple[Samples, list[tuple[int, int, Samples]]]:
    """Take out what begins suddenly.

    About each beginning, what is louder in a band than it was just before and is just after is taken out: of a click in
    a tone, the click.

    Parameters
    ----------
    sound : float32 array, shape (n_channels, n)
        Samples.
    rate : int
        Samples a second.

    Returns
    -------
    (float32 array, list of (int, int, float32 array))
        What is left; and for each sudden sound where it is loudest, where its samples lie, and these. Added up they are
        the sound again.
    """
    width = 1 << round(np.log2(rate / 47))
    hop = width // 4
    window = np.sqrt(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(width) / width)).astype(np.float32)
    before, after = round(_BEFORE * rate), round(_AFTER * rate)
    taken: list[tuple[int, int, Samples]] = []
    for place, _ in beginnings(sound, rate):
        # Whole windows before the beginning and after what is taken out, to compare with; and those between.
        low, high = place - before - 2 * width, place + after + 2 * width
        part = np.zeros((sound.shape[0], high - low), np.float32)
        inside = slice(max(low, 0), min(high, sound.shape[1]))
        part[:, inside.start - low : inside.stop - low] = sound[:, inside]
        frames = np.lib.stride_tricks.sliding_window_view(part, width, axis=1)[:, ::hop] * window
        spectrum = np.fft.rfft(frames, axis=2)
        size = np.abs(spectrum)
        starts = np.arange(frames.shape[1]) * hop + low
        usual = np.maximum(
            np.median(size[:, starts + width <= place - before // 2], axis=1),
            np.median(size[:, starts >= place + after], axis=1),
        )[:, None]
        share = 1 - np.minimum(1.0, 1.5 * usual / np.maximum(size, 1e-12))
        back = np.fft.irfft(spectrum * share, width, axis=2).astype(np.float32) * window
        loud = np.zeros_like(part)
        for number in range(frames.shape[1]):
            loud[:, number * hop : number * hop + width] += back[:, number] / 2
        start = max(place - before, 0)
        stop = min(place + after, sound.shape[1])
        piece = loud[:, start - low : stop - low].copy()
        fade = min(round(0.003 * rate), piece.shape[1] // 2)
        ramp = np.linspace(0, 1, fade, dtype=np.float32)
        piece[:, :fade] *= ramp
        piece[:, piece.shape[1] - fade :] *= ramp[::-1]
        sound[:, start:stop] -= piece
        taken.append((start + int(np.argmax(np.abs(piece).max(axis=0))), start, piece))
    return sound, taken


def beginnings(sound: Samples, rate: int) -> list[tuple[int, float]]:
    """Find where something begins suddenly.

    Parameters
    ----------
    sound : float32 array, shape (n_channels, n)
        Samples.
    rate : int
        Samples a second.

    Returns
    -------
    list of (int, float)
        The sample about which it begins, within some milliseconds, and how many times as loud (in energy) it gets.
    """
    width = 1 << max(4, round(np.log2(rate / 94)))
    hop = width // 4
    n = (sound.shape[1] - width) // hop + 1
    if n < 4:
        return []
    mono = sound.sum(axis=0)
    frames = np.lib.stride_tricks.sliding_window_view(mono, width)[::hop] * np.hanning(width).astype(np.float32)
    power = np.abs(np.fft.rfft(frames, axis=1)) ** 2
    # Bands half an octave wide: a tone fills one or two of them, a click all.
    edges = np.unique(np.round(np.geomspace(2, width // 2, 2 * int(np.log2(width // 4)) + 1)).astype(int))
    energy = np.add.reduceat(power, edges[:-1], axis=1)
    energy[:, -1] -= power[:, edges[-1]] if edges[-1] < power.shape[1] else 0.0
    loudest = float(energy.max())
    if loudest <= 1e-10:
        return []
    # The loudest of the 20 ms before, which a sound that swells and falls again (a beat) raises too.
    back = 8
    padded = np.concatenate([np.repeat(energy[:1], back, axis=0), energy])
    before = np.lib.stride_tricks.sliding_window_view(padded, back, axis=0)[:n].max(axis=-1)
    rise = energy / (before + _FLOOR * energy.mean(axis=0) + 1e-7 * loudest)
    # A click may be heard in high bands alone, where hardly a tone is.
    high = int(np.searchsorted(edges[:-1], 700 * width / rate))
    risen = np.maximum((rise > _RISE).mean(axis=1), (rise[:, high:] > _RISE).mean(axis=1))
    found: list[tuple[int, float]] = []
    last = -n
    for frame in np.flatnonzero(risen >= _BANDS).tolist():
        if frame - last > back:
            # It has come in at the window's end, where the window is low.
            found.append((frame * hop + round(0.8 * width), float(np.median(rise[frame]))))
        last = frame
    return found
