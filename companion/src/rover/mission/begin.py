"""A survey ready to begin: on ground that nobody knows, or with what an earlier run has learned."""

from __future__ import annotations

from rover.detection.classifier import Classifier
from rover.mission.config import Mission
from rover.mission.former_run import FormerRun, go_on_from
from rover.mission.perception import Perception
from rover.mission.survey import Survey
from rover.vision.camera.model import CameraModel


def begin(
    mission: Mission, camera: CameraModel, classifier: Classifier, seed: int, former: FormerRun | None = None
) -> Survey:
    """The survey of a mission. Raises BadInput where the earlier run does not fit."""
    vehicle = mission.rover.vehicle
    known = former.keyframes if former is not None else None
    survey = Survey(mission, vehicle, Perception(mission, vehicle, camera, classifier, known), seed)
    if former is not None:
        go_on_from(former, survey)
    return survey
