"""The study's material: clips of the data folder, and where they walk, jump and strike."""
