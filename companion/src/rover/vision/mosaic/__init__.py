"""Many pictures in one plane."""
