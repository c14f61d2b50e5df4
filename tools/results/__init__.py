"""Keeps the figures in docs true: runs the command that stands beside each and writes or compares what it prints.

A page holds blocks like

    <!-- results cheap tolerance=2%: .venv/bin/python -m tools.bench protocol --only sizes -->
    …
    <!-- /results -->

`cheap`: a few seconds, compared by `make test`. `text`: what is printed goes into a fenced block. `tolerance`: by how
much a number may differ, relative (`2%`) or absolute (`0.1`); without it none may. A command runs in the repository's
root and may write to the folder $SCRATCH, which goes afterwards; one that names $ROVER_DATA is left out where that is
not set.
"""
