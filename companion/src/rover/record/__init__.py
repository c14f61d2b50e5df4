"""Writers of a run's files: the log in MCAP, trajectories in TUM format, results in GeoJSON."""
