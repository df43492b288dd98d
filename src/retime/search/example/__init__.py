"""What a stretch that was retimed by hand says of a whole clip: how fast each moment should play, and how surely."""
