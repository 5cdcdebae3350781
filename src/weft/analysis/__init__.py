"""What a sample is: the scale of its structure, how regular it is, whether it tiles."""
