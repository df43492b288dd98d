"""A warp from footage alone; apart from the rest of the study, since it needs the extra ``video``."""
