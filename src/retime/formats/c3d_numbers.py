"""How numbers are stored in a C3D: by Intel, DEC and SGI machines, 16-bit or real."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray, doubles

INTEL, DEC, SGI = 84, 85, 86
MACHINES = {INTEL: "Intel", DEC: "DEC", SGI: "SGI"}
"""The byte of a parameter section that says who wrote the numbers, and who that is."""
# Exponents are counted from here: a DEC number is its fraction, from one half to one, times 2**(exponent - 128).
_DEC_BIAS = 128


@dataclass(frozen=True)
class Numbers:
    """Numbers of one machine.

    Attributes
    ----------
    machine : int
        `INTEL`, `DEC` or `SGI`.
    """

    machine: int

    @property
    def order(self) -> str:
        """Byte order of whole numbers, as NumPy writes it."""
        return ">" if self.machine == SGI else "<"

    def words(self, data: bytes | memoryview, *, signed: bool = False) -> FloatArray:
        """Read 16-bit numbers, as doubles."""
        return np.frombuffer(data, dtype=f"{self.order}{'i' if signed else 'u'}2").astype(np.float64)

    def word(self, data: bytes, place: int) -> int:
        """Read one unsigned 16-bit number."""
        return int.from_bytes(data[place : place + 2], "big" if self.machine == SGI else "little")

    def pack_words(self, values: FloatArray, *, signed: bool = False) -> bytes:
        """Write 16-bit numbers: rounded, and what is out of their range at its end."""
        low, high = (-(1 << 15), (1 << 15) - 1) if signed else (0, (1 << 16) - 1)
        return np.clip(np.rint(values), low, high).astype(f"{self.order}{'i' if signed else 'u'}2").tobytes()

    def reals(self, data: bytes | memoryview) -> FloatArray:
        """Read 32-bit real numbers, as doubles; what DEC reserves is not a number.

        Examples
        --------
        >>> Numbers(DEC).reals(bytes([0x80, 0x40, 0, 0, 0x20, 0xC1, 0, 0])).tolist()
        [1.0, -2.5]
        """
        if self.machine != DEC:
            return doubles(np.frombuffer(data, dtype=f"{self.order}f4"))
        bits = _swapped(np.frombuffer(data, dtype="<u4"))
        exponent = (bits >> 23 & 0xFF).astype(np.int64)
        fraction = ((bits & 0x7FFFFF) | 0x800000).astype(np.float64) / (1 << 24)
        values = np.ldexp(fraction, exponent - _DEC_BIAS)
        negative = bits >> 31 == 1
        values = np.where(negative, -values, values)
        return np.where(exponent == 0, np.where(negative, np.nan, 0.0), values)

    def pack_reals(self, values: FloatArray) -> bytes:
        """Write 32-bit real numbers; not a number is what DEC reserves, and what is too large for DEC its largest.

        Examples
        --------
        >>> [float(x) for x in Numbers(DEC).reals(Numbers(DEC).pack_reals(np.array([0.1, -7.0, 0.0])))]
        [0.10000000149011612, -7.0, 0.0]
        """
        if self.machine != DEC:
            with np.errstate(over="ignore"):
                return np.asarray(values).astype(f"{self.order}f4").tobytes()
        values = np.asarray(values, dtype=np.float64)
        fraction, exponent = np.frexp(np.where(np.isfinite(values), np.abs(values), 0.5))
        whole = np.rint(fraction * (1 << 24)).astype(np.int64)
        # What rounds up to the next power of two.
        carried = whole == 1 << 24
        whole, exponent = np.where(carried, 1 << 23, whole), exponent + carried + _DEC_BIAS
        bits = (exponent.astype(np.int64) << 23) | (whole & 0x7FFFFF)
        bits = np.where((exponent < 1) | (values == 0), 0, bits)
        bits = np.where((exponent > 255) | np.isinf(values), 0x7FFFFFFF, bits)
        bits |= ((values < 0) & (bits != 0)).astype(np.int64) << 31
        bits = np.where(np.isnan(values), 1 << 31, bits)
        return _swapped(bits.astype(np.uint32)).astype("<u4").tobytes()

    def real(self, data: bytes, place: int) -> float:
        """Read one real number."""
        return float(self.reals(data[place : place + 4])[0])


def _swapped(bits: np.ndarray) -> np.ndarray:
    """Exchange the halves of 32-bit numbers: DEC writes the upper one first, each with its lower byte first."""
    return np.asarray((bits >> np.uint32(16)) | (bits << np.uint32(16)), dtype=np.uint32)
