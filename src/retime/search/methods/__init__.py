"""The ways to look for a path: exact, exact for a cycle, and the paper's from coarse to fine."""
