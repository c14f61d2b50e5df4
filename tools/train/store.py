"""Vectors once made are kept in a folder, so that another round of training begins at once."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]


def kept(folder: Path | None, name: str, make: Callable[[], Arrays]) -> Arrays:
    """The arrays of `name`: from the folder if they lie there, else made and laid there. No folder, no keeping.

    The name must tell everything that the arrays depend on but the code: who changes that, empties the folder.
    """
    if folder is None:
        return make()
    file = folder / f"{name}.npz"
    if file.is_file():
        with np.load(file) as stored:
            return {key: stored[key] for key in stored.files}
    arrays = make()
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(file, **arrays)  # type: ignore[arg-type]  # the stub takes any name for its own allow_pickle
    return arrays


def digest(files: Iterable[Path]) -> str:
    """Of the contents of files, for a name: what other code has made is not taken for this code's."""
    told = hashlib.sha256()
    for file in files:
        told.update(file.read_bytes())
    return told.hexdigest()[:12]
