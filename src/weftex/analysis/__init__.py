"""What a sample is: its scale, regularity and lattice, and whether it tiles."""
