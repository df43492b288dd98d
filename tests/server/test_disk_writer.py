"""Changes on their way to the disk."""

from __future__ import annotations

import asyncio
import threading

import pytest

from retime.server.disk_writer import Change, DiskWriter


class Disk:
    """A disk that writes down what happens to it; writing waits until it is let."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.may_write = threading.Event()

    def change(self, name: str, *, gesture: str = "", error: Exception | None = None) -> Change:
        def write() -> None:
            assert self.may_write.wait(30)
            if error is not None:
                raise error
            self.told.append(f"wrote {name}")

        return Change(
            write,
            done=lambda: self.told.append(f"done {name}"),
            failed=lambda raised: self.told.append(f"{name}: {raised}"),
            gesture=gesture,
        )


def written(*changes: tuple[str, str], error: Exception | None = None) -> list[str]:
    """Put changes, by names and gestures, while the first of them is being written; the second one fails."""

    async def run() -> list[str]:
        disk = Disk()
        writer = DiskWriter(fault=lambda raised: disk.told.append(f"fault: {raised}"))
        for i, (name, gesture) in enumerate(changes):
            writer.drop_last_of(gesture)
            writer.put(disk.change(name, gesture=gesture, error=error if i == 1 else None))
            await asyncio.sleep(0)
        disk.may_write.set()
        await writer.close()
        await asyncio.sleep(0)
        return disk.told

    return asyncio.run(run())


def test_changes_are_written_in_order_each_before_it_is_called_done() -> None:
    assert written(("a", ""), ("b", ""), ("c", "")) == ["wrote a", "done a", "wrote b", "done b", "wrote c", "done c"]


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ([("a", ""), ("b", "g"), ("c", "g"), ("d", "g")], "ad"),
        # Of two gestures, or of none, each is written; so is what was begun already.
        ([("a", ""), ("b", "g"), ("c", "h"), ("d", "g")], "abcd"),
        ([("a", ""), ("b", ""), ("c", "")], "abc"),
        ([("a", "g"), ("b", "g")], "ab"),
    ],
)
def test_of_a_gesture_the_latest_that_waits_is_written(changes, names) -> None:
    assert [told[-1] for told in written(*changes) if told.startswith("wrote")] == list(names)


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), ZeroDivisionError("a fault of the program")])
def test_what_can_not_be_written_is_told_and_the_next_is_written(error) -> None:
    assert written(("a", ""), ("b", ""), ("c", ""), error=error) == [
        "wrote a",
        "done a",
        f"b: {error}",
        "wrote c",
        "done c",
    ]


def test_faults_of_those_who_are_told_are_told_too_and_the_next_is_written() -> None:
    told: list[str] = []

    def fail(error: object) -> None:
        raise ZeroDivisionError(f"after {error}")

    async def run() -> None:
        writer = DiskWriter(fault=lambda error: told.append(str(error)))
        writer.put(Change(lambda: told.append("wrote a"), done=lambda: fail("a"), failed=lambda e: told.append(str(e))))
        writer.put(Change(lambda: fail("b"), done=lambda: told.append("done b"), failed=fail))
        writer.put(Change(lambda: told.append("wrote c"), done=lambda: told.append("done c"), failed=fail))
        await writer.close()

    asyncio.run(run())
    assert told == ["wrote a", "after a", "after after b", "wrote c", "done c"]


def test_all_changes_are_written_by_one_thread_which_ends_with_the_writer() -> None:
    # Each other thread would keep for good the memory that the largest change needs.
    threads: list[threading.Thread] = []

    async def run() -> None:
        writer = DiskWriter(fault=lambda error: None)
        for _ in range(20):
            done = asyncio.Event()
            change = Change(lambda: threads.append(threading.current_thread()), done.set, failed=lambda error: None)
            writer.put(change)
            await done.wait()
            # Asyncio takes a new thread for what comes while its others are idle, too.
            await asyncio.gather(*(asyncio.to_thread(int) for _ in range(3)))
        await writer.close()

    asyncio.run(run())
    assert len(threads) == 20
    assert set(threads) == {threads[0]}
    assert threads[0] is not threading.main_thread()
    assert not threads[0].is_alive()
