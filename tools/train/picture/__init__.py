"""Trains the network for pictures that know neither kelvin nor metres, from real pictures."""
