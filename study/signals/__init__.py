"""Beyond motion (the paper's Figure 4, and its hope): a camera, a curve, and a signal that has no skeleton."""
