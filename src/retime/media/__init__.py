"""Video, pictures and sound by a warp (the paper's figure 4).

`apply.py` holds the one call, `retime_media`. It checks what a file is (`kinds.py`) and has a process work on it that
may die of what it holds (`process.py`, `child.py`). That one opens the file (`opening.py`), reads frames at random
(`reader.py`) and sound by spans (`sound_reader.py`), mixes them (`mixing.py`, `sound.py`) as the plans of `times.py`
and `pieces.py` say, and encodes (`encoding.py`, `work.py`). `features.py` finds what moves in a video, as a signal.
"""
