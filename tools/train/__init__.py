"""Trains the classifier: synthetic fields through the rover's own path, and real pictures where they are given."""
