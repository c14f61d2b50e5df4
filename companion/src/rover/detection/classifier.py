"""The classifiers: small neural networks (256 and 128 hidden units, paper section 3.2.1), run by onnxruntime.

There are two, each in a file of its own, because a candidate is described in different terms: `ground` in kelvin and
metres (`rover.detection.ground.patch`), `pictures` without either (`rover.detection.picture.patch`).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.ground import patch as ground_patch
from rover.detection.model_file import open_model, shipped
from rover.detection.picture import patch as picture_patch
from rover.errors import BadInput

CLASSES = ("obstacle", "surface", "buried", "background")
MINES = ("surface", "buried")
GROUND, PICTURES = "ground", "pictures"
# The threshold of a file that tells none: the mission's, from which a place is reported.
DEFAULT_THRESHOLD = EvidenceSettings.report_threshold
# Numbers per candidate that a network of each kind takes.
LENGTHS = {GROUND: ground_patch.LENGTH, PICTURES: picture_patch.LENGTH}


def default_model(kind: str = GROUND) -> str:
    """Path of the model of this kind that ships."""
    return str(shipped(f"landmine_{kind}.onnx"))


class Classifier:
    """A model file that maps vectors of its kind to probabilities.

    kind: GROUND or PICTURES, the one that is needed; None: whichever the file is. Raises BadInput (one line: file, what
    is wrong, what to do) when the file is missing or does not fit.
    """

    def __init__(self, path: str | Path, kind: str | None = GROUND) -> None:
        file = Path(path)
        again = f"train one with python -m tools.train {kind or '|'.join(LENGTHS)}"
        self._session, self.sha256 = open_model(file, again)
        metadata = self._session.get_modelmeta().custom_metadata_map
        self.kind = metadata.get("kind", "nothing")
        if self.kind not in LENGTHS or kind not in (None, self.kind):
            wanted = kind or " or ".join(LENGTHS)
            raise BadInput(f"{file}: a network for {self.kind}, one for {wanted} is needed; {again}")
        self.length = LENGTHS[self.kind]
        self.classes: tuple[str, ...] = tuple(filter(None, metadata.get("classes", "").split(",")))
        if sorted(self.classes) != sorted(CLASSES):
            found = ", ".join(self.classes) or "nothing"
            raise BadInput(f"{file}: classes are {found}, expected {', '.join(CLASSES)}; {again}")
        inputs = self._session.get_inputs()
        length = inputs[0].shape[-1] if len(inputs) == 1 and len(inputs[0].shape) == 2 else None
        if length != self.length or inputs[0].type != "tensor(float)":
            raise BadInput(f"{file}: takes {length} numbers per candidate, this version gives {self.length}; {again}")
        # What is a mine with at least this probability is a detection where nobody asks for another threshold.
        self.threshold = float(metadata.get("threshold", DEFAULT_THRESHOLD))
        # SHA-256 of the file of features that a network for pictures was trained with.
        self.features_sha256 = metadata.get("features", "")
        self._input = inputs[0].name
        self.path = str(file)
        self._check_answers(file, again)

    def _check_answers(self, file: Path, again: str) -> None:
        """A model whose weights are spoiled answers with anything but probabilities."""
        answer = self._session.run(None, {self._input: np.zeros((2, self.length), np.float32)})[0]
        if answer.shape != (2, len(self.classes)) or not np.allclose(answer.sum(axis=1), 1.0, atol=1e-3):
            raise BadInput(f"{file}: its answers are no probabilities of {len(self.classes)} classes; {again}")

    def predict(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        """Vectors (N, length) to probabilities (N, classes), in the order of `classes`."""
        if batch.ndim != 2 or batch.shape[1] != self.length:
            raise BadInput(f"batch of shape {batch.shape}: (N, {self.length}) is expected")
        if not len(batch):
            return np.zeros((0, len(self.classes)), np.float32)
        answer: NDArray[np.float32] = self._session.run(None, {self._input: np.ascontiguousarray(batch, np.float32)})[0]
        return answer
