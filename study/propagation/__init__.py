"""What a hand did to one stretch, and how much of it comes back where the hand never was."""
