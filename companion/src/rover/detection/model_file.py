"""Model files: where those that ship lie, whether one is the file that was evaluated, and a session that runs it."""

from __future__ import annotations

import hashlib
from pathlib import Path

import onnxruntime

from rover.errors import BadInput
from rover.plain_file import plain_file


def shipped(name: str) -> Path:
    """Path of the file of this name that ships: beside the sources, or inside the installed package."""
    here = Path(__file__).resolve()
    places = (here.parents[3] / "models" / name, here.parents[1] / "models" / name)
    return next((place for place in places if place.is_file()), places[0])


def open_model(file: Path, again: str) -> tuple[onnxruntime.InferenceSession, str]:
    """A session, and the SHA-256 of the file.

    again: what to do for another file. Raises BadInput (one line: file, what is wrong, what to do) where the file
    cannot be read, is not the one that the `.sha256` beside it names, or is no model.
    """
    try:
        content = plain_file(file).read_bytes()
    except OSError as error:
        raise BadInput(f"{file}: the classifier cannot be read ({error.strerror}); {again}") from error
    sha256 = hashlib.sha256(content).hexdigest()
    _check_hash(file, sha256)
    options = onnxruntime.SessionOptions()
    # One thread: the same bytes give the same result, and the other core belongs to localization.
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"]), sha256
    except Exception as error:  # onnxruntime raises many types, none of them documented
        raise BadInput(f"{file}: not an ONNX model; {again}") from error


def _check_hash(file: Path, found: str) -> None:
    """Where a `.sha256` lies beside a model, the model must be the one that was evaluated."""
    try:
        wanted = file.with_suffix(".sha256").read_text(encoding="ascii").split()[0]
    except (OSError, ValueError, IndexError):
        return
    if wanted != found:
        raise BadInput(f"{file}: its SHA-256 is {found[:12]}…, the file beside it says {wanted[:12]}…; restore it")
