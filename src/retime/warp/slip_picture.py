"""A small picture of how far feet slide."""

from __future__ import annotations

from typing import TYPE_CHECKING

from retime.svg import INKS, Panel, facts_html, stacked

if TYPE_CHECKING:
    from retime.warp.slip import SlipReport

_SLIPS = {
    "input": "input",
    "unaveraged": "no averaging",
    "plain": "all averaged",
    "contact_aware": "feet exempt",
}


def slip_html(report: SlipReport) -> str:
    """Return the mean slip of the input, and of the output however it is averaged, as bars."""
    means = {label: getattr(report, name).mean for name, label in _SLIPS.items()}
    about = "about " * report.input.size_guessed
    panel = Panel(
        f"mean slip of a standing foot ({about}mm)", 0.0, max(*means.values(), 1e-9), -len(means) + 0.5, 0.5, of="mm"
    )
    for lane, (label, mean) in enumerate(means.items()):
        panel.rule(-lane, "")
        panel.bar(0.0, mean, -lane, ink=INKS[lane])
        panel.note(-lane, f"{label} {mean:.1f}")
    largest = {f"largest, {label}": f"{about}{getattr(report, name).largest:.1f} mm" for name, label in _SLIPS.items()}
    return stacked(panel.svg(), facts_html({"contacts": len(report.input.contacts), **largest}))
