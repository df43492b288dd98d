"""Keypoints of people in footage: `format` is what the registry calls; a file each for what wrote them."""
