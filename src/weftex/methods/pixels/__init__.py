"""What methods that choose single pixels share."""
