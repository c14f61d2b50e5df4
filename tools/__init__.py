"""Tools for developers: generate, train, calibrate, flash, bench."""
