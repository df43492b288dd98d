"""What each choice is worth: the same questions asked with one choice changed at a time.

Two kinds of question have a known answer. *Preservation*: a clip with jumps gets another length, and every in-flight
frame should keep unit speed. *Imitation*: one stretch is retimed by hand, and the rest should follow (`study.answers`).
"""
