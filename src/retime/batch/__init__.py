"""Whole libraries of clips, on an engine that exists (Dask): broken clips are reported, the others go on."""

from retime.batch.clip import retime_clip
from retime.batch.recipe import Recipe, Rule, read_recipe
from retime.batch.run import BatchResult, run
from retime.batch.task import ClipTask, Record
from retime.batch.treatment import Treatment

__all__ = ["BatchResult", "ClipTask", "Recipe", "Record", "Rule", "Treatment", "read_recipe", "retime_clip", "run"]
