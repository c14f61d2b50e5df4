"""A mission from its file to its report: configuration, the loop that ties every part together, its phases."""
