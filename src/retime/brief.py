"""How values show themselves at a prompt: on a line or two, whatever they hold.

What a dataclass prints of itself is every number of every array. Here an array is its type and shape, a long tuple the
number of its items, and what was left at its default is left out.

NumPy is imported only where a value is looked at: the command line's help must not wait for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from fractions import Fraction
from typing import Any

# The most letters of one field's value, and the most items of a tuple, that are written out.
_LONGEST, _MOST_ITEMS = 72, 4


def text_of(value: object) -> str:
    """Return ``str(value)``; where Python refuses to write out a number of thousands of digits, say that it has them.

    Examples
    --------
    >>> text_of(120), text_of(10**5000)
    ('120', 'a number of thousands of digits')
    """
    try:
        return str(value)
    except ValueError:
        return "a number of thousands of digits"


def brief(value: object) -> str:
    """Write one value in few letters.

    Examples
    --------
    >>> import numpy as np
    >>> brief(np.zeros((816, 3))), brief(0.1 + 0.2), brief(tuple(range(31))), brief(Fraction(60))
    ('float64 (816, 3)', '0.3', 'tuple of 31', '60')
    """
    import numpy as np

    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Fraction):
        return str(value)
    if isinstance(value, str):
        return repr(value if len(value) <= _LONGEST else value[: _LONGEST - 1] + "…")
    if isinstance(value, bytes) and len(value) > _LONGEST:
        return f"{len(value)} bytes"
    if isinstance(value, tuple | list | set | frozenset | dict):
        return _brief_items(value)
    text = text_of(value) if isinstance(value, int) else repr(value)
    if len(text) > 3 * _LONGEST or "\n" in text:
        return f"<{type(value).__name__}>"
    return text


def _brief_items(items: Collection[Any]) -> str:
    counted = f"{type(items).__name__} of {len(items)}"
    if len(items) > _MOST_ITEMS:
        return counted
    if isinstance(items, Mapping):
        text = "{" + ", ".join(f"{brief(key)}: {brief(value)}" for key, value in items.items()) + "}"
    elif isinstance(items, tuple):
        text = "(" + ", ".join(map(brief, items)) + ("," if len(items) == 1 else "") + ")"
    elif isinstance(items, list):
        text = "[" + ", ".join(map(brief, items)) + "]"
    else:
        text = "{" + ", ".join(sorted(map(brief, items))) + "}" if items else counted
    return text if len(text) <= _LONGEST else counted


def brief_repr(self: Any) -> str:
    """Write a dataclass: to be its ``__repr__``.

    Examples
    --------
    >>> import numpy as np
    >>> @dataclasses.dataclass(frozen=True, eq=False)
    ... class Samples:
    ...     values: np.ndarray
    ...     rate: float
    ...     name: str = ""
    ...     __repr__ = brief_repr
    >>> Samples(np.zeros((2, 3)), 30.0)
    Samples(values=float64 (2, 3), rate=30)
    """
    shown = []
    for field in dataclasses.fields(self):
        value = getattr(self, field.name)
        if value is None or value is field.default or (isinstance(value, Collection) and len(value) == 0):
            continue
        shown.append(f"{field.name}={brief(value)}")
    return f"{type(self).__name__}({', '.join(shown)})"


def kind_of(value: object) -> str:
    """Name what was passed in place of what was expected, for messages.

    Examples
    --------
    >>> import numpy as np
    >>> kind_of([1, 2]), kind_of("walk.bvh"), kind_of(np.zeros(3)), kind_of(None)
    ('a list', "the text 'walk.bvh'", 'an array of shape (3,)', 'None')
    """
    import numpy as np

    if value is None:
        return "None"
    if isinstance(value, str):
        return f"the text {brief(value)}"
    if isinstance(value, bool | int | float | complex | np.number):
        return f"the number {value!s:.60}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"
