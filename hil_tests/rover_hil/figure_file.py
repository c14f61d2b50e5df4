"""Figures to files: PNG or SVG, whichever the file's name ends in; the same figure gives the same bytes."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from rover.errors import BadInput

FORMATS = (".png", ".svg")
DOTS_PER_INCH = 150


def write_figure(figure: Figure, path: Path) -> None:
    """Raises BadInput for another ending, or where the file cannot be written."""
    ending = path.suffix.lower()
    if ending not in FORMATS:
        raise BadInput(f"{path}: a plot is written as PNG or SVG: give a name that ends in {' or '.join(FORMATS)}")
    # Without these an SVG would carry the date and random names.
    metadata = {"Date": None} if ending == ".svg" else None
    with matplotlib.rc_context({"svg.hashsalt": "rover", "svg.fonttype": "none"}):
        try:
            figure.savefig(path, format=ending[1:], dpi=DOTS_PER_INCH, metadata=metadata)
        except OSError as error:
            raise BadInput(f"{path}: the plot cannot be written ({error.strerror or error})") from error
