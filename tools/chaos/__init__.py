"""A campaign of faults that nobody chose: kills, full disks, pulled wires, damaged runs, hostile files.

A trial is one command, or one mission and what happens to it, made from a seed. What has to hold stands in `verdict`.
"""
