"""A camera's intrinsics, its mount on the rover, and a pair of cameras."""
