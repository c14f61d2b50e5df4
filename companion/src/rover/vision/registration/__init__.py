"""Where one picture lies in another: ORB features, DBSCAN, RANSAC, refinement, verification."""
