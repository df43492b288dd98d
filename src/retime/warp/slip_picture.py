"""A small picture of how far feet slide."""

from __future__ import annotations

from collections.abc import Mapping

from retime.svg import INKS, Panel, facts_html, stacked


def slip_html(slips: Mapping[str, tuple[float, float]], n_contacts: int, *, guessed: bool) -> str:
    """Return mean slips as bars.

    Parameters
    ----------
    slips : mapping of str to (float, float)
        What was measured, with the mean and the largest slip of a contact, millimetres.
    n_contacts : int
        Contacts of the input.
    guessed : bool
        The figure's size is guessed, so these are about as long.
    """
    means = {label: mean for label, (mean, _) in slips.items()}
    about = "about " * guessed
    panel = Panel(
        f"mean slip of a standing foot ({about}mm)", 0.0, max(*means.values(), 1e-9), -len(means) + 0.5, 0.5, of="mm"
    )
    for lane, (label, mean) in enumerate(means.items()):
        panel.rule(-lane, "")
        panel.bar(0.0, mean, -lane, ink=INKS[lane])
        panel.note(-lane, f"{label} {mean:.1f}")
    largest = {f"largest, {label}": f"{about}{most:.1f} mm" for label, (_, most) in slips.items()}
    return stacked(panel.svg(), facts_html({"contacts": n_contacts, **largest}))
