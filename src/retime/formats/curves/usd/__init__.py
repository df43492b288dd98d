"""USD: `format` is what the registry calls; pxr is imported by the process that `child` is, and nowhere else."""
