"""Sine and cosine by their series, in exact fractions."""

from __future__ import annotations

from fractions import Fraction

# Digits of pi far beyond those of a double.
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211707")
_BITS = 200


def sine_and_cosine(angle: float) -> tuple[Fraction, Fraction]:
    """Both of an angle in radians, right to some 50 digits."""
    left = Fraction(angle)
    if abs(left) < Fraction(1, 1 << 60):
        # More terms are below the last digit asked for.
        return left - left**3 / 6, 1 - left**2 / 2
    left -= round(left / (2 * PI)) * 2 * PI
    # Rounded now and then: exact fractions grow with every product.
    left = _rounded(left)
    sums = [Fraction(0), Fraction(0)]
    term, n = Fraction(1), 0
    while abs(term) > Fraction(1, 1 << 180):
        sums[n % 2] += term if n % 4 < 2 else -term
        n += 1
        term = _rounded(term * left / n)
    return sums[1], sums[0]


def _rounded(number: Fraction) -> Fraction:
    return Fraction(round(number * (1 << _BITS)), 1 << _BITS)
