"""A survey ready to begin: on ground that nobody knows, with what an earlier run has learned, or as a second visit."""

from __future__ import annotations

from rover.detection.classifier import Classifier
from rover.detection.hours import warning
from rover.mission.config import Mission
from rover.mission.earlier_visit import take_over
from rover.mission.former_run import FormerRun, go_on_from
from rover.mission.perception import Perception
from rover.mission.survey import Survey
from rover.mission.visit_again import earlier_visit
from rover.vision.camera.model import CameraModel


def begin(
    mission: Mission,
    camera: CameraModel,
    classifier: Classifier,
    seed: int,
    former: FormerRun | None = None,
    earlier: FormerRun | None = None,
) -> Survey:
    """The survey of a mission. former: the run that it goes on from; earlier: a survey of the field at another hour.

    Raises BadInput where either does not fit.
    """
    vehicle = mission.rover.vehicle
    known = former.keyframes if former is not None else None
    survey = Survey(mission, vehicle, Perception(mission, vehicle, camera, classifier, known), seed)
    if former is not None:
        go_on_from(former, survey)
    poor = warning(mission.time_of_day_s / 3600.0)
    if poor:
        survey.timeline.append((0.0, poor))
    if earlier is not None:
        survey.earlier = earlier_visit(earlier, survey.perception)
        take_over(survey.earlier, survey.perception, earlier.next_place)
        reported = sum(place.indication for place in earlier.places)
        survey.timeline.append((0.0, f"second visit, after {survey.earlier.name}: {reported} indications are kept"))
    return survey
