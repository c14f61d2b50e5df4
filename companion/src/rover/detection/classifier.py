"""The classifier: a small neural network (256 and 128 hidden units, paper section 3.2.1), run by onnxruntime."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from rover.detection.patch import LENGTH
from rover.errors import BadInput

CLASSES = ("obstacle", "surface", "buried", "background")
MINES = ("surface", "buried")
MODEL_NAME = "landmine_mlp.onnx"


def default_model() -> str:
    """Path of the model that ships with the project: beside the sources, or inside the installed package."""
    here = Path(__file__).resolve()
    places = (here.parents[3] / "models" / MODEL_NAME, here.parents[1] / "models" / MODEL_NAME)
    return str(next((place for place in places if place.is_file()), places[0]))


def _check_hash(file: Path, found: str) -> None:
    """Where a `.sha256` lies beside a model, the model must be the one that was evaluated."""
    try:
        wanted = file.with_suffix(".sha256").read_text(encoding="ascii").split()[0]
    except (OSError, ValueError, IndexError):
        return
    if wanted != found:
        raise BadInput(f"{file}: its SHA-256 is {found[:12]}…, the file beside it says {wanted[:12]}…; restore it")


class Classifier:
    """A model file that maps vectors of `patch.describe` to probabilities.

    Raises BadInput (one line: file, what is wrong, what to do) when the file is missing or does not fit.
    """

    def __init__(self, path: str | Path) -> None:
        file = Path(path)
        try:
            content = file.read_bytes()
        except OSError as error:
            raise BadInput(
                f"{file}: the classifier cannot be read ({error.strerror}); train one with python -m tools.train"
            ) from error
        self.sha256 = hashlib.sha256(content).hexdigest()
        _check_hash(file, self.sha256)
        options = onnxruntime.SessionOptions()
        # One thread: the same bytes give the same result, and the other core belongs to localization.
        options.intra_op_num_threads = 1
        options.inter_op_num_threads = 1
        options.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime raises many types, none of them documented
            raise BadInput(f"{file}: not an ONNX model; train one with python -m tools.train") from error
        metadata = self._session.get_modelmeta().custom_metadata_map
        self.classes: tuple[str, ...] = tuple(filter(None, metadata.get("classes", "").split(",")))
        if sorted(self.classes) != sorted(CLASSES):
            found = ", ".join(self.classes) or "nothing"
            raise BadInput(f"{file}: classes are {found}, expected {', '.join(CLASSES)}; train it anew")
        inputs = self._session.get_inputs()
        length = inputs[0].shape[-1] if len(inputs) == 1 and len(inputs[0].shape) == 2 else None
        if length != LENGTH or inputs[0].type != "tensor(float)":
            raise BadInput(f"{file}: takes {length} numbers per candidate, this version gives {LENGTH}; train it anew")
        self._input = inputs[0].name
        self.path = str(file)
        self._check_answers(file)

    def _check_answers(self, file: Path) -> None:
        """A model whose weights are spoiled answers with anything but probabilities."""
        answer = self._session.run(None, {self._input: np.zeros((2, LENGTH), np.float32)})[0]
        if answer.shape != (2, len(self.classes)) or not np.allclose(answer.sum(axis=1), 1.0, atol=1e-3):
            raise BadInput(f"{file}: its answers are no probabilities of {len(self.classes)} classes; train it anew")

    def predict(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """Vectors (N, LENGTH) to probabilities (N, classes), in the order of `classes`."""
        if batch.ndim != 2 or batch.shape[1] != LENGTH:
            raise BadInput(f"batch of shape {batch.shape}: (N, {LENGTH}) is expected")
        if not len(batch):
            return np.zeros((0, len(self.classes)), np.float32)
        return self._session.run(None, {self._input: np.ascontiguousarray(batch, np.float32)})[0]
