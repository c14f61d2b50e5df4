"""From a finished survey and what the referee saw to one RunResult; nothing is computed later than here."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.link.statistics import LinkFigures
from rover.mission.ending import short_of
from rover.mission.freespace import disc_mask
from rover.mission.fresh_ground import fresh_wheel_area
from rover.mission.goals import Goal, GoalState
from rover.mission.survey import Survey
from rover.mission.track import Track
from rover.outcome import RunStatus
from rover.record.ate import absolute_trajectory_error
from rover.record.epoch import NO_EPOCH, Epoch
from rover.record.relative_error import relative_error
from rover.record.tum import read_tum
from rover.report.result import (
    Coverage,
    DetectionResult,
    Found,
    GoalKind,
    GoalResult,
    HomeResult,
    Identities,
    Localization,
    MapLayers,
    ObstacleResult,
    ObstacleSource,
    PlateResult,
    RunResult,
    Safety,
    TimelineEntry,
    Unsurveyed,
)
from rover.report.visits import PlaceVisits, TwoVisitsResult

# Half the side of a detection's picture in the report, metres.
THUMBNAIL_HALF = 0.3
# Occupied spots smaller than this, in cells, are not worth a row in the report.
OBSTACLE_CELLS = 12


def assemble(
    survey: Survey,
    track: Track,
    figures: LinkFigures,
    identities: Identities,
    referee: Mapping[str, Any] | None,
    out: Path,
    epoch: Epoch = NO_EPOCH,
) -> RunResult:
    """The result of a run. `referee`: what a simulated rig counted, None where nobody did.

    `epoch`: of the mission's clock.
    """
    assert survey.outcome is not None
    perception = survey.perception
    grid = perception.grid
    grid.settle()
    area = survey.mission.area
    start = track.start
    shown = survey.coverage.wanted & ~survey.coverage.unshown()
    coverage = _coverage(survey, referee)
    timeline = [TimelineEntry(at - start, text) for at, text in survey.timeline]
    outcome, home = survey.outcome, survey.conclusion.home
    if outcome.status is RunStatus.DONE and coverage.share < coverage.required:
        # The rover's own map knows no more to see: only the truth tells that there is.
        outcome = short_of(coverage.share, coverage.required)
        timeline.append(TimelineEntry(track.duration, f"{outcome.status}: {outcome.reason} (by the truth)"))
    return RunResult(
        mission=survey.mission.name,
        status=outcome.status,
        reason=outcome.reason,
        duration=track.duration,
        distance=track.distance,
        area_width=area.width,
        area_height=area.height,
        launch=survey.mission.launch.pose,
        path=track.fused[::5, :3],
        layers=MapLayers((0.0, 0.0), grid.resolution, grid.temperature, shown, grid.occupied),
        identities=identities,
        site=survey.mission.site,
        epoch=epoch if epoch == NO_EPOCH else epoch.after(start),
        detections=_detections(survey, start),
        goals=tuple(
            GoalResult(
                id=number,
                x=goal.x,
                y=goal.y,
                reached=goal.state is GoalState.INSPECTED,
                kind=GoalKind.OPERATOR if goal.place_id is None else GoalKind.INSPECTION,
                reason="" if goal.state is GoalState.INSPECTED else _why_not(survey, goal),
                time=None if goal.inspected_at is None else goal.inspected_at - start,
            )
            for number, goal in enumerate(survey.goals, start=1)
            if goal.state is not GoalState.DISMISSED  # the ground there proved to be plain: nothing is left to inspect
        ),
        obstacles=_obstacles(survey),
        unsurveyed=_unsurveyed(survey),
        surveyed_area=float(shown.sum()) * grid.resolution**2,
        fresh_wheel=fresh_wheel_area(track.fused[:, 1:4], survey.vehicle),
        wanted_area=float(survey.coverage.wanted.sum()) * grid.resolution**2 if area.polygon or area.exclude else None,
        coverage=coverage,
        home=None if home is None else HomeResult(home.reached, home.reason),
        safety=_safety(referee, survey.contacts.count),
        found=_found(referee),
        localization=_localization(survey, track, out),
        link=asdict(figures),
        timeline=tuple(timeline),
        final_pose=track.final_pose,
        robot_radius=survey.vehicle.radius,
        visits=_visits(survey),
    )


def _visits(survey: Survey) -> TwoVisitsResult | None:
    fused = survey.fused
    if fused is None:
        return None
    settings = survey.perception.evidence.settings
    places = {
        place.id: PlaceVisits(
            first=None if place.earlier is None else place.earlier["surface"] + place.earlier["buried"],
            second=place.mine_probability if place.is_found(settings) else None,
            together=fused.said[place.id].p,
            contrast=(fused.said[place.id].first, fused.said[place.id].second),
            inertia=fused.said[place.id].inertia,
        )
        for place in survey.perception.indications
    }
    two, shift = fused.two, fused.registered.shift
    return TwoVisitsResult(
        earlier=fused.earlier.name,
        hours=two.hours,
        registered_by=fused.registered.by,
        shift=(shift.x, shift.y, math.degrees(shift.heading)),
        matches=fused.registered.matches,
        agreement=fused.registered.agreement,
        first=two.kelvin[0],
        second=two.kelvin[1],
        difference=two.difference,
        places=places,
    )


def _detections(survey: Survey, start: float) -> tuple[DetectionResult, ...]:
    goals = {goal.place_id: goal for goal in survey.goals if goal.place_id is not None}
    results = []
    for place in survey.perception.indications:
        goal = goals.get(place.id)
        inspected = goal is not None and goal.state is GoalState.INSPECTED
        kind, p = place.reported_as
        results.append(
            DetectionResult(
                id=place.id,
                kind=kind,
                p=p,
                x=place.x,
                y=place.y,
                sigma=survey.perception.map_sigma(place),
                relative_sigma=place.sigma_m,
                views=place.views,
                zone_radius=survey.mission.detector.keepout_radius,
                first_seen=max(place.first_seen - start, 0.0),
                inspected=inspected,
                why_not="" if inspected else _why_not(survey, goal),
                probabilities=dict(place.p),
                thumbnail=_cut(survey, place.x, place.y),
            )
        )
    return tuple(results)


def _why_not(survey: Survey, goal: Goal | None) -> str:
    """Why a goal, or an indication without one, was not inspected."""
    if goal is not None and goal.reason:
        return goal.reason
    assert survey.outcome is not None
    return f"the mission ended before ({survey.outcome.reason})"


def _cut(survey: Survey, x: float, y: float) -> NDArray[np.float32] | None:
    """Kelvin around a place, row 0 at the top; None where nothing was seen."""
    grid = survey.perception.grid
    half = round(THUMBNAIL_HALF / grid.resolution)
    padded = np.pad(grid.temperature, half, constant_values=np.nan)
    row, column = int(y / grid.resolution), int(x / grid.resolution)
    cut = padded[row : row + 2 * half + 1, column : column + 2 * half + 1]
    return cut[::-1].copy() if np.isfinite(cut).any() else None


def _obstacles(survey: Survey) -> tuple[ObstacleResult, ...]:
    grid = survey.perception.grid
    found = [ObstacleResult(x, y, r, ObstacleSource.GIVEN) for x, y, r in survey.mission.area.obstacles]
    found += [ObstacleResult(x, y, r, ObstacleSource.TOUCHED) for x, y, r in survey.contacts.discs]
    count, _, stats, centres = cv2.connectedComponentsWithStats(grid.occupied.astype(np.uint8), connectivity=8)
    for label in range(1, count):
        cells = int(stats[label, cv2.CC_STAT_AREA])
        if cells >= OBSTACLE_CELLS:
            x, y = ((centres[label] + 0.5) * grid.resolution).tolist()
            radius = math.sqrt(cells * grid.resolution**2 / math.pi)
            found.append(ObstacleResult(x, y, radius, ObstacleSource.THERMAL))
    return tuple(found)


def _unsurveyed(survey: Survey) -> tuple[Unsurveyed, ...]:
    """Unseen ground by reason, the largest first; keep-out zones are told apart from what cannot be reached."""
    grid = survey.perception.grid
    assert survey.outcome is not None
    unseen, hidden = survey.coverage.unseen(), survey.coverage.hidden()
    zones = np.zeros_like(unseen)
    for zone in survey.perception.keepout.active:
        zones |= disc_mask(grid.shape, grid.resolution, zone.x, zone.y, zone.radius)
    rest = (
        "out of view from all ground that the rover could reach"
        if survey.exhausted
        else f"the mission ended before ({survey.outcome.reason})"
    )
    parts = [
        (unseen & zones, "inside a keep-out zone"),
        (hidden, "hidden behind an obstacle from every viewpoint tried"),
        (unseen & ~zones, rest),
    ]
    cell = grid.resolution**2
    found = [Unsurveyed(float(mask.sum()) * cell, reason) for mask, reason in parts if mask.any()]
    return tuple(sorted(found, key=lambda part: -part.area))


def _coverage(survey: Survey, referee: Mapping[str, Any] | None) -> Coverage:
    required = survey.mission.required_coverage
    by_truth = referee.get("coverage") if referee is not None else None
    if by_truth is not None:
        return Coverage(float(by_truth), required, by_truth=True)
    return Coverage(survey.own_coverage(), required, by_truth=False)


def _found(referee: Mapping[str, Any] | None) -> Found | None:
    if referee is None or "mines" not in referee:
        return None
    rows = referee["mines"]
    return Found(
        mines=len(rows),
        found=sum(bool(row["found"]) for row in rows),
        with_contrast=int(referee["mines_with_contrast"]),
        with_contrast_found=int(referee["mines_with_contrast_found"]),
        false=int(referee["false_indications"]),
    )


def _safety(referee: Mapping[str, Any] | None, felt: int) -> Safety:
    if referee is None:
        return Safety(bumper_contacts=felt)
    return Safety(
        collisions=_count(referee, "collisions"),
        bumper_contacts=max(felt, _count(referee, "bumper_contacts") or 0),
        keepout_violations=_count(referee, "keepout_violations"),
        unseen_ground=referee.get("unseen_ground_m2"),
        min_clearance=referee.get("min_clearance_m"),
        wheel_over_mine=_count(referee, "wheel_over_mine"),
    )


def _count(referee: Mapping[str, Any], key: str) -> int | None:
    value = referee.get(key)
    return None if value is None else int(value)


def _localization(survey: Survey, track: Track, out: Path) -> Localization:
    fused = wheels = relative = inside = None
    # A real field, or a rig that is gone: nobody knows the truth.
    with suppress(BadInput):
        truth = read_tum(out / "truth.tum")
        fused = absolute_trajectory_error(track.fused, truth)
        if "wheels" in survey.mission.sources:
            wheels = absolute_trajectory_error(track.wheels, truth)
        relative, inside = relative_error(track.among_things, truth, 0.5 * survey.vehicle.track_width)
    return Localization(
        ate_rmse=fused,
        odometry_only_ate_rmse=wheels,
        relative_rmse=relative,
        inside_95=inside,
        max_relative_sigma=track.max_relative_sigma,
        fixes=survey.perception.fixes,
        rejected=survey.perception.rejected,
        final_sigma=track.final_sigma,
        max_sigma=track.max_sigma,
        plates=tuple(
            PlateResult(plate.x, plate.y, plate.seen, plate.off)
            for plate in survey.perception.markers.told(survey.perception.localizer)
        ),
    )
