"""How good a warp is: figures of merit, and plots."""
