"""The classifier: a small neural network (256 and 128 hidden units, paper section 4.2), run by onnxruntime."""

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
        self.sha256 = hashlib.sha256(content).hexdigest()

    def predict(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """Vectors (N, LENGTH) to probabilities (N, classes), in the order of `classes`."""
        if batch.ndim != 2 or batch.shape[1] != LENGTH:
            raise BadInput(f"batch of shape {batch.shape}: (N, {LENGTH}) is expected")
        if not len(batch):
            return np.zeros((0, len(self.classes)), np.float32)
        return self._session.run(None, {self._input: np.ascontiguousarray(batch, np.float32)})[0]
