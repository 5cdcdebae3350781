"""Pictures as arrays: masks, box sums, pyramids; each once."""
