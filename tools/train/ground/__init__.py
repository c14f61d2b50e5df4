"""Trains the network for candidates in kelvin and metres, from synthetic fields."""
