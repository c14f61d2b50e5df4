"""What a reader cannot see in one file: how full the folders are, who imports whom in a circle, what nobody needs."""
