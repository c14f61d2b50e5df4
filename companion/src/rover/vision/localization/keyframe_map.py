"""A run's keyframes kept in a file, so that the next run over the same ground knows where it is.

An npz archive (its members carry checksums) with the keyframes of every submap, their poses in it with all covariances,
the graph of the submaps, and the camera: a keyframe tells something only to the camera and mount that it was made with.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rover.archive_file import UNREADABLE, damaged, read_archive, write_archive
from rover.errors import BadInput
from rover.geometry import Pose2
from rover.vision.camera.model import CameraModel
from rover.vision.localization.keyframes import Keyframe
from rover.vision.localization.submap_graph import Edge, Tie
from rover.vision.registration.matching import BITS

FILE_NAME = "keyframes.npz"
WHAT = "keyframe map"
# Of the file, and of what descriptors mean: one more when either changes.
VERSION = 2

_SAME = 1e-9


Mount = tuple[NDArray[np.float64], NDArray[np.float64]]
"""The camera's offset and stretch (3,) and their covariance (3, 3), see `pose_filter`."""


@dataclass(frozen=True, eq=False)
class SubmapRecord:
    """frames: K keyframes, oldest first. poses (K, 3): x, y (m), heading (rad) in the submap. covariance (3K, 3K)."""

    frames: list[Keyframe]
    poses: NDArray[np.float64]
    covariance: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KeyframeMap:
    """All submaps, what ties them to each other and to map, and the one that the rover was in at last.

    launch, sigma: the rover's pose in map at the beginning, and its 1σ. mount: how the camera was found to sit, None in
    maps that do not tell.
    """

    submaps: list[SubmapRecord]
    submap_poses: list[Pose2]
    edges: list[Edge]
    ties: list[Tie]
    launch: Pose2
    sigma: tuple[float, float, float]
    active: int
    mount: Mount | None = None

    @property
    def frames(self) -> list[Keyframe]:
        """The keyframes of all submaps."""
        return [frame for submap in self.submaps for frame in submap.frames]


def save_map(path: Path, known: KeyframeMap, camera: CameraModel) -> None:
    """Writes the map; the same map gives the same bytes. Raises BadInput where the file cannot be written."""
    write_archive(path, WHAT, map_arrays(known, camera))


def map_arrays(known: KeyframeMap, camera: CameraModel) -> dict[str, NDArray[Any]]:
    """The map as the arrays of its file."""
    frames = known.frames
    return {
        "version": np.array(VERSION),
        "camera": np.frombuffer(json.dumps(asdict(camera)).encode(), np.uint8),
        "graph": np.frombuffer(json.dumps(_graph(known)).encode(), np.uint8),
        "keyframes": np.array([len(submap.frames) for submap in known.submaps], np.int64),
        "poses": _joined([submap.poses for submap in known.submaps], (0, 3)),
        "covariance": _joined([submap.covariance.ravel() for submap in known.submaps], (0,)),
        "time": np.array([frame.time for frame in frames]),
        "features": np.array([len(frame.descriptors) for frame in frames], np.int64),
        "ground": _joined([frame.ground for frame in frames], (0, 2)),
        "pixel_m": _joined([frame.pixel_m for frame in frames], (0,)),
        "descriptors": _joined([frame.descriptors for frame in frames], (0, BITS // 8)).astype(np.uint8),
    }


def _graph(known: KeyframeMap) -> dict[str, Any]:
    """Submaps, edges and ties as JSON values."""
    return {
        "submaps": [_row(pose) for pose in known.submap_poses],
        "edges": [
            [edge.first, edge.other, _row(edge.pose), edge.covariance.tolist(), edge.place] for edge in known.edges
        ],
        "ties": [[tie.submap, tie.seen, tie.known, tie.covariance.tolist()] for tie in known.ties],
        "launch": _row(known.launch),
        "sigma": known.sigma,
        "active": known.active,
        "mount": None if known.mount is None else [part.tolist() for part in known.mount],
    }


def _row(pose: Pose2) -> list[float]:
    return [pose.x, pose.y, pose.heading]


def load_map(place: Path, camera: CameraModel) -> KeyframeMap:
    """The map in a run's folder, or in the file given.

    Raises BadInput, one line, for a file that is missing, damaged, of another version, or made with another camera.
    """
    path = place / FILE_NAME if place.is_dir() else place
    content = read_archive(path, WHAT)
    try:
        version = int(content["version"])
        if version != VERSION:
            raise BadInput(f"{path}: keyframe map of version {version}; this rover reads version {VERSION}")
        made_with = json.loads(content["camera"].tobytes())
        known = _unpacked(content)
    except BadInput:
        raise
    except UNREADABLE as error:
        raise damaged(path, WHAT) from error
    differing = _differing(made_with, camera)
    if differing:
        raise BadInput(f"{path}: made with another camera or mount: {', '.join(differing)} differ from {camera.name}'s")
    return known


def _joined(parts: list[NDArray[Any]], empty: tuple[int, ...]) -> NDArray[Any]:
    return np.concatenate(parts) if parts else np.empty(empty)


def _unpacked(content: dict[str, NDArray[Any]]) -> KeyframeMap:
    """Raises ValueError or KeyError where the arrays do not belong together."""
    features, keyframes = content["features"], content["keyframes"]
    count, total = len(features), int(features.sum())
    shapes = {
        "poses": (count, 3),
        "covariance": (int((9 * keyframes**2).sum()),),
        "time": (count,),
        "ground": (total, 2),
        "pixel_m": (total,),
        "descriptors": (total, BITS // 8),
    }
    for name, shape in shapes.items():
        if content[name].shape != shape or not np.isfinite(content[name]).all():
            raise ValueError(name)
    if count == 0 or features.min() < 1 or keyframes.min() < 1 or int(keyframes.sum()) != count:
        raise ValueError("features")
    ends = np.cumsum(features)[:-1]
    ground, pixel_m, descriptors = (np.split(content[name], ends) for name in ("ground", "pixel_m", "descriptors"))
    frames = [Keyframe(ground[k], descriptors[k], pixel_m[k], float(content["time"][k])) for k in range(count)]
    lasts = np.cumsum(keyframes)
    poses = np.split(content["poses"], lasts[:-1])
    covariances = np.split(content["covariance"], np.cumsum(9 * keyframes**2)[:-1])
    submaps = [
        SubmapRecord(frames[last - len(pose) : last], pose, covariance.reshape(3 * len(pose), 3 * len(pose)))
        for last, pose, covariance in zip(lasts.tolist(), poses, covariances, strict=True)
    ]
    return _with_graph(submaps, json.loads(content["graph"].tobytes()))


def _with_graph(submaps: list[SubmapRecord], graph: dict[str, Any]) -> KeyframeMap:
    """Raises ValueError, TypeError or KeyError where the graph is not one of these submaps."""
    poses = [_pose(row) for row in graph["submaps"]]
    edges = [
        Edge(_number(first, poses), _number(other, poses), _pose(pose), _finite(covariance, (3, 3)), _pair(place))
        for first, other, pose, covariance, place in graph["edges"]
    ]
    ties = [
        Tie(_number(submap, poses), _pair(seen), _pair(known), _finite(covariance, (2, 2)))
        for submap, seen, known, covariance in graph["ties"]
    ]
    x, y, heading = _finite(graph["sigma"], (3,)).tolist()
    if len(poses) != len(submaps) or not min(x, y, heading) > 0.0:
        raise ValueError("graph")
    active = _number(graph["active"], poses)
    return KeyframeMap(
        submaps, poses, edges, ties, _pose(graph["launch"]), (x, y, heading), active, _mount(graph.get("mount"))
    )


def _number(value: Any, poses: list[Pose2]) -> int:
    number = int(value)
    if not 0 <= number < len(poses):
        raise ValueError("graph")
    return number


def _pose(row: Any) -> Pose2:
    x, y, heading = _finite(row, (3,)).tolist()
    return Pose2(x, y, heading)


def _pair(row: Any) -> tuple[float, float]:
    x, y = _finite(row, (2,)).tolist()
    return x, y


def _finite(values: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError("graph")
    return array


def _differing(made_with: dict[str, Any], camera: CameraModel) -> list[str]:
    """Names of what matters to a keyframe and is not the same."""
    names = []
    for name, value in asdict(camera).items():
        if name == "name":
            continue
        former, now = (np.atleast_1d(np.asarray(v, float)) for v in (made_with.get(name, np.nan), value))
        if former.shape != now.shape or not np.allclose(former, now, rtol=0.0, atol=_SAME):
            names.append(name)
    return names


def _mount(told: Any) -> Mount | None:
    """Absent in maps of earlier versions."""
    if told is None:
        return None
    mean, covariance = told
    return _finite(mean, (3,)), _finite(covariance, (3, 3))
