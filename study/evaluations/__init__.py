"""The paper's eight evaluations (§4, V1 to V8) on public captures, at sizes as near to Table 1 as those allow.

Each is one file, v1.py to v8.py (v6b.py, v6c.py and v7b.py are further ones, with known answers). It holds `KEY`, its
name; `PAPER`, its row of the paper's Table 1 or None; and `evaluate`, which shows what the paper's video shows, beside
what else a person could do. `study.evaluations.registry` finds the files by themselves.
"""
