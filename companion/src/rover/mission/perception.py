"""What the rover knows: its pose, the map, the places, the zones. Every sensor enters here and nowhere else."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.detection.classifier import Classifier
from rover.detection.evidence_settings import EvidenceSettings
from rover.detection.fusion import Evidence
from rover.detection.ground.detect import DetectSettings, detect
from rover.detection.ground.image import GroundRectifier
from rover.detection.place import Place
from rover.geometry import Pose2
from rover.link.telemetry import Battery, SonarRange, Telemetry, WheelMotion
from rover.link.words import SonarStatus
from rover.mapping.parallax import Parallax
from rover.mapping.survey_grid import SurveyGrid
from rover.mission.config import Mission
from rover.mission.fault_table import Check
from rover.mission.goals import Goal
from rover.mission.handling import Handling
from rover.mission.inertial import Inertial
from rover.mission.keepout import KeepOut, Zone
from rover.mission.markers import Markers
from rover.mission.surroundings import among_things
from rover.record.relative_error import RelativePose
from rover.vehicle import Vehicle
from rover.vision.camera.level import levelled
from rover.vision.camera.model import CameraModel
from rover.vision.localization.cold_plate import without
from rover.vision.localization.fix import Fix
from rover.vision.localization.keyframe_map import KeyframeMap
from rover.vision.localization.localizer import Localizer
from rover.vision.localization.settings import LocalizerSettings
from rover.vision.registration.steps import with_steps

# The operator sets the rover down by a mark on the ground: 1σ of position (m) and heading (rad).
LAUNCH_SIGMA = (0.005, 0.005, math.radians(0.5))
# 1σ in metres of the rover's place among the ground around it beyond which it neither maps nor drives: what is mapped
# wrong stays wrong. One limit for both, so that a rover which may drive also learns where to.
PLACED_SIGMA = 0.05
# No wheel touches a place that was found so often and is a mine with at least this probability, reported or not.
AVOIDED_VIEWS = 3
AVOIDED_FROM = 0.15
# Every so many frames one is mapped and searched: 0.24 s apart, 6 cm of driving or 16° of turning, a third of the view.
MAP_EVERY = 2
# Way that the rover still makes once a new zone has it stop, metres: the frame's delay, the wire, and braking.
BRAKING = 0.13
# Less wheel travel than this between two reports is standing still, metres.
STANDING = 0.0004
# Past an obstacle as near to the hull as this, metres, and on ground whose flatness nothing has told, the rover goes no
# faster than the bumper is made for, m/s: a tuft's rim reaches farther than what is seen of it.
NEAR_OBSTACLE_M = 0.06
TOUCH_SPEED = 0.1
# The edge of a mine's warmth is steep: an error of the pose spreads there what is flat, metres from its middle.
MINE_EDGE_M = 0.15
# Submaps whose parallax is kept, beside that of the one that the rover is in: it goes to and fro between neighbours.
PARALLAXES = 3
# An inspection counts when the place was in view in this many frames of it.
INSPECTION_VIEWS = 4


class Perception:
    """Estimators and maps of one mission; deterministic in what it is given."""

    def __init__(
        self,
        mission: Mission,
        vehicle: Vehicle,
        camera: CameraModel,
        classifier: Classifier,
        known: KeyframeMap | None = None,
    ) -> None:
        """known: keyframes of an earlier run; with them the rover begins by finding out where it is."""
        area = mission.area
        self.vehicle = vehicle
        self.camera = camera
        # On frames alone wheels only tell that the rover moves, and what time it is.
        self._by_wheels = "wheels" in mission.sources
        motion: Literal["wheels", "frames"] = "wheels" if self._by_wheels else "frames"
        settings = LocalizerSettings(motion=motion, track_width=vehicle.track_width)
        settings = replace(settings, preprocess=with_steps(settings.preprocess, mission.rover.preprocess))
        self.localizer = Localizer(camera, mission.launch.pose, LAUNCH_SIGMA, settings, known=known)
        self.grid = SurveyGrid(area.width, area.height)
        self.evidence = Evidence(EvidenceSettings(report_threshold=mission.detector.report_threshold))
        self.keepout = KeepOut(mission.detector.keepout_radius)
        self.markers = Markers(mission.plates, camera, mission.time_of_day_s / 3600.0)
        self.battery: Battery | None = None
        self.last_fix: Fix | None = None
        self.released: set[int] = set()
        self.frames = 0
        self.fixes = 0
        self.rejected = 0
        self._classifier = classifier
        self._rectifier = GroundRectifier(camera)
        self._area = (area.width, area.height)
        self._counts: tuple[int, int] | None = None
        self.handling = Handling(vehicle)
        self.inertial = Inertial()
        self._moving = False
        self._time = 0.0
        self._shown = self._shown_before = 0  # frames that showed ground: the shutter open, the place known
        self._footprint = self.grid.view_polygon(camera)
        # Of the submaps that the rover was in lately, the present one last.
        self._parallaxes: dict[int, Parallax] = {}
        # How the submaps lay in map when they were looked at last, and in which of them the rover was.
        self._submaps = list(self.localizer.atlas.graph.poses)
        self._submap = self.localizer.atlas.active
        self._shift: Pose2 | None = None
        self.parallax = Parallax(self.grid.resolution)
        start = self.localizer.inside(mission.launch.pose)
        self.parallax.bear(start.x, start.y, mission.launch.surveyed_radius)

    @property
    def pose(self) -> Pose2:
        """Where the rover believes to be, in map."""
        return self.localizer.pose if self._by_wheels else self.localizer.pose_at(self._time)

    @property
    def sigma(self) -> float:
        """1σ of the position in map, metres, along its worse axis: it is measured from the launch and grows with it."""
        return _worse_axis(self.localizer.covariance)

    @property
    def relative_sigma(self) -> float:
        """1σ of the position among the ground that the rover sees, metres, along its worse axis.

        Ground that was seen from another side is off by what is not known of the camera's mount, too.
        """
        return math.hypot(_worse_axis(self.localizer.relative_covariance), self.localizer.offset[1])

    @property
    def placed(self) -> bool:
        """True when the rover knows its place among the ground around it: only then it may drive, and maps.

        Obstacles, zones and seen ground lie where they were seen from; how far all of it is off from the launch does
        not matter to them.
        """
        return not self.localizer.lost and self.relative_sigma <= PLACED_SIGMA

    @property
    def suspected(self) -> list[Place]:
        """Places inside the area that may be mines, whether reported yet or not.

        One that was inspected and did not become an indication then is `released`: report and zones agree on it.
        """
        return [place for place in self._places_inside() if self._is_suspected(place)]

    @property
    def avoided(self) -> list[Place]:
        """Places inside the area that no wheel may touch: the suspected ones, and all that are not unlikely enough.

        What was inspected and is no indication, but no plain ground either, is not driven over.
        """
        return [
            place
            for place in self._places_inside()
            if self._is_suspected(place) or (place.views >= AVOIDED_VIEWS and place.mine_probability >= AVOIDED_FROM)
        ]

    def _is_suspected(self, place: Place) -> bool:
        return place.indication or (place.suspected and place.id not in self.released)

    def _places_inside(self) -> list[Place]:
        width, height = self._area
        return [place for place in self.evidence.places if 0.0 <= place.x <= width and 0.0 <= place.y <= height]

    @property
    def indications(self) -> list[Place]:
        """Places inside the area that are reported as indications of a mine."""
        return [place for place in self.suspected if place.indication]

    @property
    def zones(self) -> list[Zone]:
        """Where no wheel goes: around what may be a mine, and on marker plates."""
        return self.keepout.active + self.markers.zones(self.localizer)

    def map_sigma(self, place: Place) -> float:
        """1σ of a place in map along one axis, metres: among the ground around it, and of that ground in map."""
        spread = self.localizer.atlas.spread_of((place.x, place.y), place.submap)
        return math.sqrt(place.sigma_m**2 + 0.5 * float(spread.trace()))

    @property
    def footprint(self) -> NDArray[np.float64]:
        """Ground that one frame shows, polygon (N, 2) in base_link."""
        return self._footprint

    def take(self, event: Telemetry) -> None:
        """One piece of telemetry."""
        self.inertial.take(event)
        self._feel(event)
        if isinstance(event, WheelMotion):
            turn = self.inertial.turn(event.time)
            if self._counts is not None:
                scales = self.vehicle.wheel_scales
                left = (event.left_counts - self._counts[0]) * scales[0]
                right = (event.right_counts - self._counts[1]) * scales[1]
                if self._by_wheels:
                    self.localizer.predict(event.time, left, right, turn)
                self._moving = max(abs(left), abs(right)) > STANDING
            self._time = event.time
            self._counts = (event.left_counts, event.right_counts)
        elif isinstance(event, SonarRange) and event.status != SonarStatus.DEAD:
            pose = self.localizer.inside(self.localizer.pose_at(event.time))
            self.grid.integrate_sonar(pose, self.vehicle.sonars[event.sensor], event.range_m)
        elif isinstance(event, Battery):
            self.battery = event

    def _feel(self, event: Telemetry) -> None:
        """Whoever is lifted, and whoever is set down, is somewhere else."""
        before = Check.HANDLED in self.handling.active
        self.handling.take(event)
        if before != (Check.HANDLED in self.handling.active):
            self.localizer.lose()

    def see(self, frame: Frame, now: float) -> bool:
        """One frame: where was it taken, what does it show? True when the map has changed."""
        self.frames += 1
        up = self.inertial.up(frame.time)
        if up is not None and not frame.ffc:
            frame = levelled(frame, self.camera, up)
        plates = self.markers.recognised(self.markers.find(frame), self.localizer.view_at(frame.time), self.sigma)
        frame = without(frame, [spot for _, spot in plates])
        self.last_fix = self.localizer.observe(frame)
        if self.last_fix.accepted and self.placed:
            self.markers.tie(plates, self.localizer.view_at(frame.time), self.localizer)
        self._follow_submaps()
        if self.last_fix.accepted:
            self.fixes += 1
        elif not frame.ffc:
            self.rejected += 1
        if frame.ffc or not self.placed:
            return False
        self._shown += 1
        pose = self.localizer.view_at(frame.time)
        self._see_what_stands(frame, pose)
        if self.frames % MAP_EVERY:
            return False
        image = self._rectifier.rectify(frame)
        detections = detect(image, self._classifier, DetectSettings())
        self.grid.integrate_frame(frame, self.camera, self.localizer.inside(pose), self.relative_sigma, detections)
        self.evidence.update(detections, pose, self.localizer.relative_covariance, frame.time, self._submap)
        here = self.pose
        reach = self.vehicle.wheel_reach + (BRAKING if self._moving else 0.0)
        self.keepout.update(self.avoided, now, (here.x, here.y), reach)
        return True

    def _see_what_stands(self, frame: Frame, pose: Pose2) -> None:
        own = self.localizer.inside(pose)
        places = [self.localizer.inside(Pose2(place.x, place.y, 0.0)) for place in self.avoided]
        found = self.parallax.integrate(frame, self.camera, own, [(place.x, place.y) for place in places], MINE_EDGE_M)
        self.parallax.bear(own.x, own.y, self.vehicle.radius)
        if found is not None:
            self.grid.stand(found)

    def among_things(self) -> RelativePose | None:
        """The rover's pose as seen from where the nearest zone or obstacle was seen; None while it is not placed."""
        if not self.placed:
            return None
        return among_things(self.pose, self.localizer, self.grid, self.keepout.active)

    def shift(self) -> Pose2 | None:
        """How the ground around the rover has moved in map since this was asked last; None when it has not."""
        shift, self._shift = self._shift, None
        return shift

    def _follow_submaps(self) -> None:
        """What was seen from a submap goes where that has gone."""
        atlas = self.localizer.atlas
        poses, before = atlas.graph.poses, self._submaps
        if (len(poses), atlas.active) == (len(before), self._submap) and poses[: len(before)] == before:
            return
        shifts = {
            number: new.compose(old.inverse())
            for number, (old, new) in enumerate(zip(before, poses, strict=False))
            if new != old
        }
        if shifts:
            homes = {place.id: place.submap for place in self.evidence.places}
            self.evidence.move(shifts)
            self.keepout.move({place: shifts[home] for place, home in homes.items() if home in shifts})
        if self._submap in shifts:
            former = self._shift or Pose2(0.0, 0.0, 0.0)
            self._shift = shifts[self._submap].compose(former)
        if atlas.active != self._submap:
            self._parallaxes[self._submap] = self.parallax
            fresh = Parallax(self.grid.resolution)
            self.parallax = self._parallaxes.pop(atlas.active, fresh)
            while len(self._parallaxes) > PARALLAXES:
                del self._parallaxes[next(iter(self._parallaxes))]
        self._submaps, self._submap = list(poses), atlas.active
        self.grid.place(poses, atlas.active)

    def speed_limit(self, x: float, y: float) -> float:
        """How fast the rover may be at a place, m/s: where a touch is possible it must be one for the bumper."""
        reach, size = self.vehicle.radius + NEAR_OBSTACLE_M, self.grid.resolution
        rows = slice(max(0, int((y - reach) / size)), max(0, int((y + reach) / size) + 1))
        columns = slice(max(0, int((x - reach) / size)), max(0, int((x + reach) / size) + 1))
        at_rows, at_columns = np.nonzero(self.grid.occupied[rows, columns])
        away = np.hypot((at_rows + rows.start + 0.5) * size - y, (at_columns + columns.start + 0.5) * size - x)
        own = self.localizer.inside(Pose2(x, y, 0.0))
        if (away < reach).any() or not self.parallax.is_judged(own.x, own.y, self.vehicle.radius):
            return TOUCH_SPEED
        return math.inf

    def in_view(self, pose: Pose2) -> NDArray[np.bool_]:
        """Cells that a frame from this pose would show on open ground, (rows, columns)."""
        mask = np.zeros(self.grid.shape, np.uint8)
        corners = pose.transform(self._footprint) / self.grid.resolution
        cv2.fillConvexPoly(mask, np.round(corners).astype(np.int32), 1)
        return mask.astype(bool)

    def count_views(self, goal: Goal) -> None:
        """Notes how often a goal has been seen so far, before it is inspected."""
        self._shown_before = self._shown

    def was_viewed(self, goal: Goal) -> bool:
        """True when the goal lies on seen ground in view of the pose and enough frames came since `count_views`."""
        row = min(int(goal.y / self.grid.resolution), self.grid.shape[0] - 1)
        column = min(int(goal.x / self.grid.resolution), self.grid.shape[1] - 1)
        shown = bool(self.grid.seen[row, column] or self.grid.occupied[row, column])
        in_view = bool(self.in_view(self.pose)[row, column])
        return shown and in_view and self._shown - self._shown_before >= INSPECTION_VIEWS


def _worse_axis(covariance: NDArray[np.float64]) -> float:
    """1σ in metres along the longer axis of the position's ellipse."""
    (a, b), (_, d) = covariance[:2, :2].tolist()
    # The larger eigenvalue of a symmetric 2 x 2 matrix.
    return math.sqrt(0.5 * (a + d) + math.hypot(0.5 * (a - d), b))
