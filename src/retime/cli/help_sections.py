"""A command whose help lists its options under headings."""

from __future__ import annotations

from typing import Any

import click


class Option(click.Option):
    """An option under a heading.

    Parameters
    ----------
    section : str
        The heading.
    default_text : str
        What help says the default is, where that is not a plain value.
    """

    def __init__(self, *args: Any, section: str = "Output", default_text: str = "", **extra: Any) -> None:
        super().__init__(*args, **extra)
        self.section = section
        self.default_text = default_text

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option's names and help; of what click would add, only the default."""
        record = super().get_help_record(ctx)
        if record is None:
            return None
        shown = f"  [default: {self.default_text}]" if self.default_text else ""
        return record[0], f"{self.help}{shown}"


class SectionedCommand(click.Command):
    """Lists options section by section, in the order in which the sections first appear."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                sections.setdefault(getattr(parameter, "section", "Help"), []).append(record)
        for section, records in sections.items():
            with formatter.section(section):
                formatter.write_dl(records)
