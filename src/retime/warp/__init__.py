"""The paper: features, score, path, keytimes, the continuous warp and its use. Opens no file."""
