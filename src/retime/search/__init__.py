"""How a warp is found: the paper's method."""
