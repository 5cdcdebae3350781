"""Results: which sample pixels an output is made of; drawn, saved and replayed from that."""
