"""The map of the ground: what has been seen, what is occupied, how warm it is."""
