"""The process that runs pxr: it is asked for one thing after another, and may die of any.

Started as ``python -m retime.formats.curves.usd.child``, with requests on its standard input and answers on its
standard output (`exchange`). It has a folder of its own, and only what it is sent and what lies beside the scene.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import traceback
from fractions import Fraction
from pathlib import Path

from retime.errors import RetimeError
from retime.files import noting_reads
from retime.formats.curves.usd.exchange import NO_MEMORY, Message, receive, send
from retime.formats.read_options import Limits
from retime.warp.curve import Warp


def main(limits_text: str, work: Path) -> None:
    """Answer requests until there are no more."""
    limits = Limits(**json.loads(limits_text))
    _bound(limits)
    requests = sys.stdin.buffer
    # What pxr prints must not be taken for an answer.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    number = 0
    while (asked := receive(requests, _most_bytes(limits))) is not None:
        number += 1
        own = work / str(number)
        own.mkdir()
        try:
            with noting_reads() as read:
                answer = answered(asked, own, limits)
            # Whoever asked wants to know what it was made of, also where that could not be done.
            answer.facts["read"] = [str(path) for path in read]
            try:
                send(answer, answers)
            except ValueError as error:
                # A number that no message can hold; nothing of it is sent yet.
                send(Message({"fault": fault_words(error)}), answers)
        finally:
            shutil.rmtree(own, ignore_errors=True)


def _most_bytes(limits: Limits) -> int:
    return limits.file_bytes + limits.inflated_bytes


def _bound(limits: Limits) -> None:
    """Bound the memory, where the system can, and leave no picture of it behind."""
    if sys.platform != "win32":
        import resource

        most = 3 * limits.inflated_bytes + (2 << 30)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def answered(asked: Message, work: Path, limits: Limits) -> Message:
    """Do what is asked; an error becomes an answer."""
    from pxr import Tf

    from retime.formats.curves.usd.stage import words_of

    try:
        return _done(asked, work, limits)
    except RetimeError as error:
        return Message({"error": str(error)})
    except Tf.ErrorException as error:
        return Message({"error": words_of(error)})
    except UnicodeDecodeError:
        return Message({"error": "USD can't read it: it holds text that is not UTF-8"})
    except (MemoryError, OSError) as error:
        return Message({"error": NO_MEMORY if isinstance(error, MemoryError) else f"USD can't read it: {error}"})
    except RuntimeError as error:
        # pxr's own, such as that of a prim that has expired.
        return Message({"error": f"USD can't read it: {str(error).strip().partition(chr(10))[0][:300]}"})
    except Exception as error:
        # What a file holds may be anything, and each kind of error that it may cause is above: this is retime's own.
        return Message({"fault": fault_words(error)})


def fault_words(error: BaseException) -> str:
    """Say what kind of error it was, in one line, and where in retime it arose."""
    own = [one for one in traceback.extract_tb(error.__traceback__) if f"{os.sep}retime{os.sep}" in one.filename]
    where = f" ({'/'.join(Path(own[-1].filename).parts[-2:])}, line {own[-1].lineno})" if own else ""
    lines = str(error).splitlines() or [""]
    return f"{type(error).__name__}: {lines[0][:300]}{where}"


def _done(asked: Message, work: Path, limits: Limits) -> Message:
    from retime.formats.curves.usd.animation import names_of, read
    from retime.formats.curves.usd.facts import facts_of
    from retime.formats.curves.usd.layer_over import layer_over
    from retime.formats.curves.usd.retime import rewritten
    from retime.formats.curves.usd.stage import open_scene
    from retime.formats.curves.usd.write import written

    facts = asked.facts
    what = facts["do"]
    if what == "write":
        return Message({}, files={"": written(asked, work, text=facts["text"])})
    folder = None if facts["folder"] is None else Path(facts["folder"])
    scene = open_scene(facts["file"], asked.files[""], folder, work, facts["outside"], limits)
    rate = None if facts["rate"] is None else Fraction(*facts["rate"])
    if what == "names":
        return Message({"names": names_of(scene)})
    if what == "facts":
        return Message({"facts": facts_of(scene)})
    if what == "read":
        return read(scene, facts["animation"], rate, limits)
    warp = Warp(asked.arrays["output_times"], asked.arrays["input_times"])
    if what == "layer":
        made = layer_over(scene, warp, facts["asset"], facts["kind"], work, text=facts["text"])
    else:
        made = rewritten(
            scene,
            warp,
            work,
            rate=rate,
            average=facts["average"],
            bake=facts["bake"],
            limits=limits,
            home=facts["home"],
            name=facts["name"],
        )
    return Message({"missing": scene.missing, "left": made.left}, files=made.files)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
