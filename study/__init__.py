"""The paper's eight evaluations, run on real motion, for people who work on the method.

It uses retime as anyone would, and is no part of the package: ``python -m study`` in a checkout runs it.
"""
