"""Makes the file of features for pictures out of a network that was trained on photographs."""
