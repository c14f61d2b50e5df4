"""A run's keyframes kept in a file, so that the next run over the same ground knows where it is.

An npz archive (its members carry checksums) with the keyframes, their poses in map with all covariances, and the
camera: a keyframe tells something only to the camera and mount that it was made with.
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
from rover.vision.camera.model import CameraModel
from rover.vision.localization.keyframes import Keyframe
from rover.vision.registration.matching import BITS

FILE_NAME = "keyframes.npz"
WHAT = "keyframe map"
# Of the file, and of what descriptors mean: one more when either changes.
VERSION = 1

_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class KeyframeMap:
    """frames: K keyframes, oldest first. poses (K, 3): x, y (m), heading (rad) in map. covariance (3K, 3K) of these."""

    frames: list[Keyframe]
    poses: NDArray[np.float64]
    covariance: NDArray[np.float64]


def save_map(path: Path, known: KeyframeMap, camera: CameraModel) -> None:
    """Writes the map; the same map gives the same bytes. Raises BadInput where the file cannot be written."""
    write_archive(path, WHAT, map_arrays(known, camera))


def map_arrays(known: KeyframeMap, camera: CameraModel) -> dict[str, NDArray[Any]]:
    """The map as the arrays of its file."""
    return {
        "version": np.array(VERSION),
        "camera": np.frombuffer(json.dumps(asdict(camera)).encode(), np.uint8),
        "poses": known.poses,
        "covariance": known.covariance,
        "time": np.array([frame.time for frame in known.frames]),
        "features": np.array([len(frame.descriptors) for frame in known.frames], np.int64),
        "ground": _joined([frame.ground for frame in known.frames], (0, 2)),
        "pixel_m": _joined([frame.pixel_m for frame in known.frames], (0,)),
        "descriptors": _joined([frame.descriptors for frame in known.frames], (0, BITS // 8)).astype(np.uint8),
    }


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
    features, poses = content["features"], content["poses"]
    count, total = len(features), int(features.sum())
    shapes = {
        "poses": (count, 3),
        "covariance": (3 * count, 3 * count),
        "time": (count,),
        "ground": (total, 2),
        "pixel_m": (total,),
        "descriptors": (total, BITS // 8),
    }
    for name, shape in shapes.items():
        if content[name].shape != shape or not np.isfinite(content[name]).all():
            raise ValueError(name)
    if count == 0 or features.min() < 1:
        raise ValueError("features")
    ends = np.cumsum(features)[:-1]
    ground, pixel_m, descriptors = (
        np.split(content[name], ends) for name in ("ground", "pixel_m", "descriptors")
    )
    frames = [
        Keyframe(ground[k], descriptors[k], pixel_m[k], float(content["time"][k])) for k in range(count)
    ]
    return KeyframeMap(frames, poses, content["covariance"])


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
