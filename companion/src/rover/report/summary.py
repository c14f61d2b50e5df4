"""A result as JSON: the contract's document of `rover run`, which is summary.json."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from rover.record.epoch import NO_EPOCH
from rover.report.result import DetectionResult, GoalResult, RunResult
from rover.report.visits import visits_json


def summary(result: RunResult) -> dict[str, Any]:
    """The contract's JSON of `rover run`, in a fixed order of keys. Only `wall_clock` and `out` vary by run."""
    return {
        "status": result.status,
        "reason": result.reason,
        "mission": result.mission,
        "started_utc": None if result.epoch == NO_EPOCH else result.epoch.utc(0.0),
        "ended_utc": None if result.epoch == NO_EPOCH else result.epoch.utc(result.duration),
        "started_local": None if result.epoch == NO_EPOCH else result.epoch.local(0.0),
        "time_source": result.epoch.source,
        "site": result.site.document(),
        "duration_s": round(result.duration, 3),
        "distance_m": round(result.distance, 4),
        "fresh_wheel_m2": round(result.fresh_wheel, 4),
        "area_m2": round(result.area_m2, 4),
        "surveyed_m2": round(result.surveyed_area, 4),
        "coverage": None if result.coverage is None else round(result.coverage.share, 4),
        "coverage_by": None if result.coverage is None else "truth" if result.coverage.by_truth else "own map",
        "required_coverage": None if result.coverage is None else result.coverage.required,
        "home": None if result.home is None else asdict(result.home),
        "reasons": [{"reason": u.reason, "area_m2": round(u.area, 4)} for u in result.unsurveyed],
        "unsurveyed": [{"area_m2": round(u.area, 4), "reason": u.reason} for u in result.unsurveyed],
        "detections": [detection_json(d) for d in result.detections],
        "goals": [goal_json(g) for g in result.goals],
        "collisions": result.safety.collisions,
        "bumper_contacts": result.safety.bumper_contacts,
        "keepout_violations": result.safety.keepout_violations,
        "unseen_ground_m2": _rounded(result.safety.unseen_ground, 5),
        "min_clearance_m": _rounded(result.safety.min_clearance, 4),
        "wheel_over_mine": result.safety.wheel_over_mine,
        "mines": None if result.found is None else asdict(result.found),
        "localization": {
            "ate_rmse_m": _rounded(result.localization.ate_rmse, 5),
            "odometry_only_ate_rmse_m": _rounded(result.localization.odometry_only_ate_rmse, 5),
            "fixes": result.localization.fixes,
            "rejected": result.localization.rejected,
            "final_sigma_m": _rounded(result.localization.final_sigma, 5),
            "max_sigma_m": _rounded(result.localization.max_sigma, 5),
            "relative_rmse_m": _rounded(result.localization.relative_rmse, 5),
            "inside_95": _rounded(result.localization.inside_95, 4),
            "max_relative_sigma_m": _rounded(result.localization.max_relative_sigma, 5),
            "held_by": result.localization.held_by,
            "plates": [
                {"x": plate.x, "y": plate.y, "seen": plate.seen, "off_m": _rounded(plate.off, 4)}
                for plate in result.localization.plates
            ],
        },
        "link": {key: round(value, 9) if math.isfinite(value) else None for key, value in result.link.items()},
        "rig": result.identities.rig,
        "seed": result.identities.seed,
        "versions": {
            "rover": result.identities.rover_version,
            "firmware": result.identities.firmware_version,
            "firmware_git_hash": result.identities.firmware_git_hash,
            "board": result.identities.board,
            "schema_hash": result.identities.schema_hash,
            "model_hash": result.identities.model_hash,
            "mission_hash": result.identities.mission_hash,
            "source_hash": result.identities.source_hash,
            "camera": result.identities.camera,
            "camera_hash": result.identities.camera_hash,
            "vehicle_hash": result.identities.vehicle_hash,
        },
        "after": result.identities.after or None,
        "visits": None if result.visits is None else visits_json(result.visits),
        "wall_clock": None
        if result.wall_clock is None
        else {
            "duration_s": round(result.wall_clock.duration, 2),
            "speed_factor": round(result.wall_clock.speed_factor, 2),
        },
        "real_time": None
        if result.real_time is None
        else {
            "cycles": result.real_time.cycles,
            "overruns": result.real_time.overruns,
            "longest_cycle_ms": round(result.real_time.longest_cycle * 1e3, 1),
            "frames_dropped": result.real_time.frames_dropped,
        },
        **({} if result.recovered_until is None else {"recovered_until_s": round(result.recovered_until, 3)}),
        "out": result.out,
    }


def detection_json(detection: DetectionResult) -> dict[str, Any]:
    """One detection as in summary.json."""
    return {
        "id": detection.id,
        "class": detection.kind,
        "p": round(detection.p, 4),
        "x": round(detection.x, 4),
        "y": round(detection.y, 4),
        "sigma_m": round(detection.sigma, 4),
        "relative_sigma_m": _rounded(detection.relative_sigma, 4),
        "views": detection.views,
        "zone_radius_m": round(detection.zone_radius, 4),
        "first_seen_s": round(detection.first_seen, 3),
        "inspected": detection.inspected,
        "why_not": detection.why_not,
        "probabilities": {name: round(value, 4) for name, value in sorted(detection.probabilities.items())},
    }


def goal_json(goal: GoalResult) -> dict[str, Any]:
    """One goal as in summary.json."""
    return {
        "id": goal.id,
        "x": round(goal.x, 4),
        "y": round(goal.y, 4),
        "reached": goal.reached,
        "kind": goal.kind,
        "reason": goal.reason,
        "time_s": _rounded(goal.time, 3),
    }


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)
