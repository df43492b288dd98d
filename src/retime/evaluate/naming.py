"""What each of several warps is called, in plots and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from retime.errors import OptionError
from retime.warp.curve import Warp, WarpLike, as_warp


def name_warps(warps: WarpLike | Mapping[str, WarpLike] | Sequence[WarpLike], call: str) -> dict[str, Warp]:
    """Give each warp a name to show: that of the mapping, else its own, or its method; `call` is for messages."""
    named: dict[str, Warp] = {}
    if isinstance(warps, Mapping):
        named.update({str(label): as_warp(warp, call) for label, warp in warps.items()})
    else:
        several = warps if isinstance(warps, Sequence) and not isinstance(warps, str) else [warps]
        for warp in (as_warp(one, call) for one in several):
            label = base = warp.name or warp.method or "warp"
            number = 1
            while label in named:
                number += 1
                label = f"{base} {number}"
            named[label] = warp
    if not named:
        raise OptionError(f"there is no warp to show; pass one at least: {call}")
    return named
