"""The companion's end of a lock-stepped rig: what `rover run` starts, and drives its mission on."""
