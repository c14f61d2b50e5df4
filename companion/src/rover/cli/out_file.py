"""A command's `--out` that would cost something: its own input, or a file of another kind."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from rover.errors import BadInput


def spare_inputs(out: Path, inputs: Iterable[Path], option: str = "--out") -> None:
    """Raises BadInput when writing `out` would destroy one of the files that it is made from, under whatever name."""
    for path in inputs:
        try:
            same = os.path.samefile(out, path)
        except OSError:
            same = False
        if same:
            raise BadInput(f"{option} {out}: is {path}, which it is made from; name another file")
