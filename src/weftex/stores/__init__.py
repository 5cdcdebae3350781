"""Pictures larger than memory: files that are written block by block, by whoever makes a block."""
