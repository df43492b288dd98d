"""What became of every clip, on the disk line by line, so that a run that ends anywhere goes on where it ended.

The output folder has ``manifest.jsonl``, a line for each output or failed clip, the last one for a place holds. While a
run is at work each process that writes outputs keeps a journal of its own in ``.retime``: which places it is about to
write, and what it has written. A run that begins takes in the journals of one that did not end.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import socket
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TextIO

from retime.batch.task import ClipTask, Record, places_with
from retime.errors import OptionError, RetimeWarning
from retime.files import hold, sync_file, write_bytes

MANIFEST, TABLE, STATE = "manifest.jsonl", "manifest.parquet", ".retime"
# In the state's folder: which run is at work.
_RUN = "run"

# Of a manifest's line, what a table of all of them leaves out: it is for pictures, and for the next run.
_NOT_IN_TABLE = ("knots", "files")
_LISTS = ("others", "warnings")


@dataclass(frozen=True, eq=False)
class Known:
    """What earlier runs left.

    Attributes
    ----------
    records : dict of str to dict
        The last line about each place.
    intended : set of str
        Places that a process was about to write: what is there is a run's own.
    """

    records: dict[str, dict[str, Any]] = field(default_factory=dict)
    intended: set[str] = field(default_factory=set)

    def learn(self, record: Record, line: dict[str, Any]) -> None:
        """Take in a later line."""
        self.records[record.output or failure_key(record.name)] = line
        if record.output:
            self.records.pop(failure_key(record.name), None)

    def may_replace(self, task: ClipTask) -> bool:
        """Tell whether what stands at the places of a task is a run's own, all of it.

        A file beside an output is whose the output is. Where no run has written there is nothing to be replaced.
        """
        own = [place in self.records or place in self.intended for place in task.places]
        return any(own) and not any(
            os.path.lexists(Path(task.out, place))
            for number, mine in enumerate(own)
            if not mine
            for place in places_with(task, number)
        )


class Journal:
    """Lines that one process appends to a file of its own, each at once.

    Parameters
    ----------
    out : Path
        The folder of all outputs.
    """

    def __init__(self, out: Path) -> None:
        self._folder = out / STATE
        self._file: TextIO | None = None

    def intend(self, task: ClipTask) -> None:
        """Say which places are about to be written: those where a stranger's file stands are not."""
        free = [
            place
            for number, place in enumerate(task.places)
            if task.overwrite or not any(os.path.lexists(Path(task.out, one)) for one in places_with(task, number))
        ]
        if free:
            self._append({"intended": free})
            # Before an output is on the disk this is: a machine that is switched off leaves no file of unknown origin.
            sync_file(self._file.fileno())  # type: ignore[union-attr]

    def say_again(self, places: list[str]) -> None:
        """Say which places a process that is gone was about to write."""
        self._append({"intended": places})

    def written(self, records: Iterable[Record]) -> None:
        """Say what was written."""
        for record in records:
            if record.status == "done":
                self._append(record.to_json())

    def _append(self, line: dict[str, Any]) -> None:
        # A run that ends takes the journals away; this process may live on and work for the next.
        if self._file is not None and not Path(self._file.name).exists():
            self.close()
        if self._file is None:
            self._folder.mkdir(parents=True, exist_ok=True)
            name = f"journal-{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}.jsonl"
            self._file = (self._folder / name).open("x", encoding="utf-8")
        # What the system was handed survives the death of this process.
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()

    def close(self) -> None:
        """Close it."""
        if self._file is not None:
            self._file.close()
            self._file = None


class Manifest:
    """The manifest of an output folder, open for one run.

    Parameters
    ----------
    out : Path
        The folder; it is made.

    Raises
    ------
    OptionError
        Another run is at work in this folder.

    Attributes
    ----------
    known : Known
        What earlier runs left.
    run : str
        By which this run is known to its workers.
    """

    def __init__(self, out: Path) -> None:
        self.out = out
        (out / STATE).mkdir(parents=True, exist_ok=True)
        self._lock = (out / STATE / "lock").open("a")
        if not hold(self._lock):
            self._lock.close()
            raise OptionError(f"another run is at work in {out}: wait for its end, or stop it")
        self.run = secrets.token_hex(8)
        write_bytes(out / STATE / _RUN, self.run.encode(), overwrite=True)
        self.known = Known()
        # Of each journal, up to where it was taken in.
        self._heard: dict[Path, int] = {}
        self._take_in(out / MANIFEST)
        journals = self._take_in_journals()
        self._file = (out / MANIFEST).open("a", encoding="utf-8")
        if journals or self._heard.get(out / MANIFEST, 0) != (out / MANIFEST).stat().st_size:
            # Also where its last line is torn: the next one would be lost with it.
            self._rewrite(self.known.records.values())
            self._keep_intents()
            self._remove(journals)

    @classmethod
    def look(cls, out: Path) -> Known:
        """Return what earlier runs left, and change nothing."""
        looking = cls.__new__(cls)
        looking.out, looking.known, looking._heard = out, Known(), {}
        looking._take_in(out / MANIFEST)
        looking._take_in_journals()
        return looking.known

    def _take_in_journals(self) -> list[Path]:
        journals = sorted((self.out / STATE).glob("journal-*.jsonl"))
        for journal in journals:
            self._take_in(journal)
        return journals

    def _take_in(self, path: Path) -> None:
        """Take in the whole lines that a file has got since it was looked at last."""
        if not path.exists():
            return
        with path.open("rb") as file:
            file.seek(self._heard.get(path, 0))
            for line in file:
                # The last line of a process that died, or is at work, may end anywhere.
                if not line.endswith(b"\n"):
                    break
                self._heard[path] = self._heard.get(path, 0) + len(line)
                with contextlib.suppress(ValueError, KeyError, TypeError):
                    found = json.loads(line)
                    if "intended" in found:
                        self.known.intended.update(found["intended"])
                    else:
                        self.known.learn(Record.from_json(found), found)

    def refreshed(self, task: ClipTask) -> ClipTask:
        """Return a task that knows what the journals say by now of its places."""
        self._take_in_journals()
        before = {place: self.known.records[place] for place in task.places if place in self.known.records}
        return replace(task, before=before, overwrite=task.overwrite or self.known.may_replace(task))

    def add(self, records: Iterable[Record]) -> None:
        """Append lines."""
        for record in records:
            line = record.to_json()
            self.known.learn(record, line)
            if record.status != "kept":
                self._file.write(json.dumps(line) + "\n")
        self._file.flush()

    def finish(self, records: Iterable[Record]) -> None:
        """Write the manifest anew, and as a table; the journals are done with.

        It has these lines, and one for each output of an earlier run that is still there, and that this run neither
        made nor kept: it is known for a run's own, and will be kept where it is wanted again.

        Warns
        -----
        RetimeWarning
            There is no pyarrow for the table.
        """
        lines = [record.to_json() for record in records]
        now = {line["output"] for line in lines}
        lines += [
            line | {"status": "old"}
            for place, line in self.known.records.items()
            if line["output"] and place not in now and (self.out / place).is_file()
        ]
        journals = list((self.out / STATE).glob("journal-*.jsonl"))
        self._rewrite(lines)
        self._keep_intents()
        self._remove([*journals, *(self.out / STATE).glob("chunk-*")])
        _write_table(lines, self.out / TABLE)

    def _rewrite(self, lines: Iterable[dict[str, Any]]) -> None:
        self._file.close()
        write_bytes(self.out / MANIFEST, (json.dumps(line).encode() + b"\n" for line in lines), overwrite=True)
        self._file = (self.out / MANIFEST).open("a", encoding="utf-8")

    def _keep_intents(self) -> None:
        """Say again what a process was about to write that nobody has heard of since: it may stand there by now."""
        left = sorted(place for place in self.known.intended - self.known.records.keys() if (self.out / place).exists())
        if left:
            journal = Journal(self.out)
            journal.say_again(left)
            journal.close()

    @staticmethod
    def _remove(journals: Iterable[Path]) -> None:
        for journal in journals:
            # On Windows a file that a process has open stays; it is taken in once more, which changes nothing.
            with contextlib.suppress(OSError):
                journal.unlink()

    def close(self) -> None:
        """Let another run begin."""
        self._file.close()
        with contextlib.suppress(OSError):
            (self.out / STATE / _RUN).unlink()
        self._lock.close()


def run_at_work(out: Path) -> str:
    """Return which run is at work in a folder; "" where none is."""
    try:
        return (out / STATE / _RUN).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError):
        return ""


def failure_key(name: str) -> str:
    """Return under what a clip that failed is known."""
    return f"failed: {name}"


def read_manifest(out: Path) -> Iterator[Record]:
    """Read the manifest of an output folder."""
    with (out / MANIFEST).open(encoding="utf-8") as file:
        for line in file:
            yield Record.from_json(json.loads(line))


def _unicode(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()


def _write_table(lines: list[dict[str, Any]], place: Path) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        warnings.warn(
            f"{TABLE} is not written: it needs pyarrow (pip install 'retime[batch]'); {MANIFEST} says the same",
            RetimeWarning,
            stacklevel=2,
        )
        return
    from io import BytesIO

    rows = [
        {
            # Several texts stand on lines of their own.
            name: "\n".join(line.get(name, ())) if name in _LISTS else line.get(name, column.default)
            for name, column in Record.__dataclass_fields__.items()
            if name not in _NOT_IN_TABLE
        }
        for line in lines
    ]
    kinds = {"str": pyarrow.string(), "int": pyarrow.int64(), "float": pyarrow.float64(), "bool": pyarrow.bool_()}
    columns = [
        (name, kinds["str" if name in ("status", *_LISTS) else str(one.type).removesuffix(" | None")])
        for name, one in Record.__dataclass_fields__.items()
        if name not in _NOT_IN_TABLE
    ]
    for row in rows:
        # A name that is no Unicode has bytes as lone surrogates, which a table can't hold.
        row.update({name: _unicode(value) for name, value in row.items() if isinstance(value, str)})
    data = BytesIO()
    parquet.write_table(pyarrow.Table.from_pylist(rows, schema=pyarrow.schema(columns)), data)
    write_bytes(place, data.getvalue(), overwrite=True)
