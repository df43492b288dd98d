"""Values and their mathematics: rotations, skeletons, motions, signals, kinematics. Opens no file."""
