"""What a pose is: the numbers that describe it, and how those of a reference are made to compare."""
