"""Known answers: warps made by hand, of which the method is given a part and should find the whole.

A warp by hand changes the timing of every cycle (or jump, or punch) of a clip in the same way. Given one of them as
the reference, the method should find the others: so the whole warp is the answer to compare with.
"""
