"""Files of pictures: formats, depth, color profiles, sets of maps."""
