"""Rigs that the rover's software is tested on: plant, sensors, referee, and the server that offers them."""
