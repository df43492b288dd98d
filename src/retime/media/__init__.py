"""Video, pictures and sound by a warp (the paper's figure 4).

`apply.py` holds the one call, `retime_media`. It checks what a file is (`kinds.py`) and starts a process that may die
of what the file holds (`child.py`). That one opens the file (`opening.py`), reads frames at random (`reader.py`) and
sound by spans (`sound_reader.py`), mixes them (`mixing.py`, `sound.py`) as the plans of `times.py` and `pieces.py` say,
and encodes (`encoding.py`, `work.py`).
"""
