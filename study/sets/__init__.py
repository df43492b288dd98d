"""The old defaults beside the new: on the clips that defaults are chosen on, and once on clips that they never saw."""
