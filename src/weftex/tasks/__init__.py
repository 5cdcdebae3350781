"""What to make, written with methods."""
