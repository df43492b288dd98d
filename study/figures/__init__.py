"""Figures of merit of one version of a clip. `study.figures.registry` lists them: one entry each, column included."""
