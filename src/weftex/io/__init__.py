"""Files of pictures: formats, depth, colour profiles, sets of maps."""
