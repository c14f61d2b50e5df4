"""Commands that `rover` has when the rigs are installed."""
