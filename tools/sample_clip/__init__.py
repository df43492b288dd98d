"""The parts of tools/make_sample.py, in the order in which they follow from each other."""
