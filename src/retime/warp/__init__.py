"""The value `Warp`, from output time to input time, and what is done with it."""
