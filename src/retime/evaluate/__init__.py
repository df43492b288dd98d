"""How good a warp is: plots."""
