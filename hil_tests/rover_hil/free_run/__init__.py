"""A rig by itself, in real time, for any client: what `rover hil serve` starts."""
