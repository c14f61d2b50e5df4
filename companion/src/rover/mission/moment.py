"""One moment of a mission for those who look on: taken from the survey by the loop, made into messages elsewhere.

Messages are lines of JSON with `kind`; each is whole in itself, so that any may be missed:

state     how the mission is doing, the firmware, the goals, places and zones, the path ahead, the last events
map       rasters of the map as PNG (base64): temperature in false colours, seen ground, obstacles; row 0 at the top
picture   the last thermal picture as PNG, with the candidates that it shows
track     the way driven so far, as often as the map
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.geometry import Pose2
from rover.record.strict_json import finite
from rover.report.map_plot import png_bytes
from rover.report.palette import false_colour, temperature_span
from rover.vision.camera.model import CameraModel

if TYPE_CHECKING:
    from rover.mission.survey import Survey
    from rover.mission.track import Track

# The last lines of the timeline that are told.
EVENTS = 60
TRACK_POINTS = 800
# Colours of ground that has been seen, and of obstacles, BGR.
SEEN, SEEN_ALPHA = (200, 180, 90), 110
OBSTACLES = (40, 30, 20)


@dataclass(frozen=True, eq=False)
class Layers:
    """Copies of the map's rasters, (rows, columns) with row 0 at y = 0; temperature in kelvin, nan where unknown."""

    temperature: NDArray[np.float32]
    seen: NDArray[np.bool_]
    occupied: NDArray[np.bool_]
    resolution: float


@dataclass(frozen=True, eq=False)
class Moment:
    """What the loop hands over: nothing in it changes any more.

    state: JSON values but for infinities. places: (x, y) by number, for the picture. layers: None when not asked for.
    """

    state: Mapping[str, Any]
    track: tuple[tuple[float, float, float, float], ...]
    frame: Frame | None
    frame_pose: Pose2
    camera: CameraModel
    places: Mapping[int, tuple[float, float]]
    layers: Layers | None


def moment_of(survey: Survey, told: Mapping[str, Any], track: Track, frame: Frame | None, with_map: bool) -> Moment:
    """The moment as it is now. `told`: what the loop says of mission, link and firmware. `frame`: the last picture."""
    perception, grid = survey.perception, survey.perception.grid
    places = perception.suspected
    state = {
        **told,
        "outcome": None
        if survey.outcome is None
        else {"status": survey.outcome.status, "reason": survey.outcome.reason},
        "relative_sigma": perception.relative_sigma,
        "area": {"width_m": survey.mission.area.width, "height_m": survey.mission.area.height},
        "goals": [
            {"id": goal.id, "x": goal.x, "y": goal.y, "state": goal.state, "reason": goal.reason}
            for goal in survey.goals
        ],
        "places": [
            {
                "id": place.id,
                "class": place.kind,
                "p": place.mine_probability,
                "x": place.x,
                "y": place.y,
                "sigma_m": place.sigma_m,
                "views": place.views,
                "indication": place.indication,
            }
            for place in places
        ],
        "zones": [{"id": zone.id, "x": zone.x, "y": zone.y, "r": zone.radius} for zone in perception.keepout.active],
        "plan": survey.drive.path.tolist(),
        "events": [{"t": at, "text": text} for at, text in survey.timeline[-EVENTS:]],
    }
    layers = None
    if with_map:
        layers = Layers(grid.temperature.copy(), grid.seen.copy(), grid.occupied.copy(), grid.resolution)
    pose = perception.pose if frame is None else perception.localizer.pose_at(frame.time)
    at = {place.id: (place.x, place.y) for place in places}
    return Moment(state, tuple(track.thinned(TRACK_POINTS)), frame, pose, perception.camera, at, layers)


def messages(moment: Moment) -> dict[str, bytes]:
    """The lines by kind."""
    told: dict[str, Any] = {"state": dict(moment.state)}
    if moment.layers is not None:
        told["track"] = {"points": [[round(value, 3) for value in point] for point in moment.track]}
        told["map"] = map_message(moment.layers)
    if moment.frame is not None:
        told["picture"] = picture_message(moment.frame, moment.frame_pose, moment.camera, moment.places)
    return {kind: (json.dumps(finite({"kind": kind, **content})) + "\n").encode() for kind, content in told.items()}


def map_message(layers: Layers) -> dict[str, Any]:
    """The map as three pictures with what is not there left transparent."""
    span = temperature_span(layers.temperature)
    colours = false_colour(layers.temperature, span)
    known = np.isfinite(layers.temperature)
    rows, columns = layers.seen.shape
    return {
        "width_m": columns * layers.resolution,
        "height_m": rows * layers.resolution,
        "span_k": list(span),
        "temperature": encoded(np.dstack([colours, np.where(known, 255, 0).astype(np.uint8)])[::-1]),
        "seen": encoded(tinted(layers.seen, SEEN, SEEN_ALPHA)[::-1]),
        "obstacles": encoded(tinted(layers.occupied, OBSTACLES, 255)[::-1]),
    }


def picture_message(
    frame: Frame, pose: Pose2, camera: CameraModel, places: Mapping[int, tuple[float, float]]
) -> dict[str, Any]:
    """A thermal picture taken from `pose`, and in which pixels places of the map appear in it."""
    grey, span = stretched(frame.counts)
    width, height = frame.size
    return {
        "t": frame.time,
        "width": width,
        "height": height,
        "ffc": frame.ffc,
        "span": list(span),
        "png": encoded(grey),
        "candidates": [{"id": number, "u": u, "v": v} for number, u, v in seen_places(pose, camera, places)],
    }


def stretched(counts: NDArray[np.uint16]) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """A thermal picture as 8 bits between its percentiles 1 and 99, and these."""
    values = counts.astype(np.float32)
    low, high = (float(value) for value in np.percentile(values, (1.0, 99.0)))
    return np.clip((values - low) / max(high - low, 1.0) * 255.0, 0.0, 255.0).astype(np.uint8), (low, high)


def seen_places(
    pose: Pose2, camera: CameraModel, places: Mapping[int, tuple[float, float]]
) -> list[tuple[int, float, float]]:
    """Number and pixel of each place that is in view from `pose`."""
    if not places:
        return []
    in_base = pose.inverse().transform(np.array(list(places.values())))
    pixels = camera.ground_to_pixel(in_base)
    shown = np.isfinite(pixels).all(axis=1) & camera.inside(np.nan_to_num(pixels, nan=-1.0))
    return [
        (number, float(u), float(v))
        for number, (u, v), visible in zip(places, pixels.tolist(), shown.tolist(), strict=True)
        if visible
    ]


def tinted(mask: NDArray[np.bool_], colour: tuple[int, int, int], alpha: int) -> NDArray[np.uint8]:
    """BGRA (h, w, 4): the colour where the mask is set, nothing elsewhere."""
    picture = np.zeros((*mask.shape, 4), np.uint8)
    picture[mask] = (*colour, alpha)
    return picture


def encoded(picture: NDArray[np.uint8]) -> str:
    """A picture as PNG in base64."""
    return base64.b64encode(png_bytes(np.ascontiguousarray(picture))).decode()
