"""A folder of frames to camera poses, with and without a ground plane."""
