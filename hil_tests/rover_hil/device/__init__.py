"""A board on a port, whatever it is: what can be tested without a world around it, in its test mode, in real time."""
