"""Camera poses from a folder of frames alone: any scene that is flat enough to be registered, at an unknown scale.

1. register each frame with the ones before it
2. choose corners in each frame, follow them into its neighbours to a fraction of a pixel
3. the first homography gives a plane (eq. 7, 8) on which its corners lie; each further frame is placed by PnP
   among the points known so far, and its own corners put on the plane that these suggest
4. the last poses and points are adjusted together, the points free to leave the plane; at the end all are
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.vision.camera.model import CameraModel
from rover.vision.camera.pose import CameraPose
from rover.vision.registration.homography import apply_homography
from rover.vision.registration.refine import RefineSettings, follow, lay, strongest_corners
from rover.vision.registration.register import (
    Picture,
    Prepared,
    RegistrationSettings,
    prepare,
    register_near,
    register_prepared,
)
from rover.vision.tracking.bundle import Scene, adjust

Points = NDArray[np.float64]
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class SequenceSettings:
    """reach: with how many frames before it each frame is registered. corners: points chosen in each frame.

    min_seen: a point counts when it was followed into so many frames beside its own. scale_px: see `adjust`.
    min_placed: points on which a frame must find its place. search: frames asked when the last ones don't fit.
    window: frames adjusted together when one is added. whole: up to so many frames are adjusted at once at the end.
    """

    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    follow: RefineSettings = field(default_factory=lambda: RefineSettings(window=21, halvings=2))
    reach: int = 3
    corners: int = 250
    min_seen: int = 1
    min_placed: int = 20
    search: int = 12
    window: int = 7
    whole: int = 120
    scale_px: float = 0.5
    iterations: int = 12
    window_iterations: int = 4


@dataclass
class _View:
    """One frame: ready to be registered, its corners (N, 2) pixels and their rays (N, 2) at z = 1."""

    number: int
    prepared: Prepared
    corners: Points
    rays: Points


def track_sequence(
    pictures: Sequence[Picture], camera: CameraModel, settings: SequenceSettings, progress: Progress | None = None
) -> list[CameraPose]:
    """Poses of all frames that can be placed, in their order, in the optical axes of the first of them.

    The unit of length is the distance to the scene's plane.
    A frame that cannot be registered is left out, and the next is tried against all before it.
    """
    views: list[_View] = []
    homographies: dict[tuple[int, int], Points] = {}
    for number, picture in enumerate(pictures):
        view = _look(number, picture, camera, settings)
        homographies.update(_link(view, views, homographies, settings))
        views.append(view)
        if progress is not None:
            progress(number + 1, len(pictures))
    observed = _observe(views, homographies, camera, settings)
    placed = _place(views, homographies, observed, camera, settings)
    numbers = sorted(placed)
    if len(numbers) <= settings.whole:
        _adjust(numbers, views, placed, observed, camera, settings, (2.0, 1.0), settings.iterations)
    if not numbers:
        return []
    turn, origin = placed[numbers[0]].rotation.T, placed[numbers[0]].position
    return [CameraPose(n, turn @ (placed[n].position - origin), turn @ placed[n].rotation) for n in numbers]


def _look(number: int, picture: Picture, camera: CameraModel, settings: SequenceSettings) -> _View:
    prepared = prepare(picture, settings.registration)
    corners = _corners(prepared.sharp, settings)
    return _View(number, prepared, corners, camera.pixel_to_normalized(corners))


def _corners(picture: NDArray[np.uint8], settings: SequenceSettings) -> Points:
    """Corners spread over the picture: a grid of cells, the strongest of each."""
    distance = max(6.0, np.sqrt(picture.size / settings.corners) * 0.6)
    return strongest_corners(picture, settings.corners, settings.follow.quality, distance)


def _link(
    view: _View, views: list[_View], known: dict[tuple[int, int], Points], settings: SequenceSettings
) -> dict[tuple[int, int], Points]:
    """Homographies from earlier frames to this one; where none of the last ones fits, older ones are asked.

    known: those between earlier frames: with the first one found they tell where the others lie.
    """
    found: dict[tuple[int, int], Points] = {}
    for back, earlier in enumerate(reversed(views[-settings.search :])):
        if back >= settings.reach and found:
            break
        homography = _chained(view, earlier, views, found, known, settings)
        if homography is None:
            # Blobs cost as much as all the rest: for a frame that is tied by none yet.
            asked = replace(settings.registration, use_blobs=not found)
            homography = register_prepared(earlier.prepared, view.prepared, asked).homography
        if homography is not None:
            found[earlier.number, view.number] = homography
    return found


def _chained(
    view: _View,
    earlier: _View,
    views: list[_View],
    found: dict[tuple[int, int], Points],
    known: dict[tuple[int, int], Points],
    settings: SequenceSettings,
) -> Points | None:
    """By way of a frame in between, where both halves of the way are known."""
    for (between, _), second in found.items():
        first = known.get((earlier.number, between))
        if first is not None:
            return register_near(earlier.prepared, view.prepared, second @ first, settings.registration)
    return None


# (anchor, frame) → which corners of the anchor were found in the frame, and their rays there (N, 2).
Observed = dict[tuple[int, int], tuple[NDArray[np.intp], Points]]


def _observe(
    views: list[_View], homographies: dict[tuple[int, int], Points], camera: CameraModel, settings: SequenceSettings
) -> Observed:
    observed: Observed = {}
    for (a, b), forward in homographies.items():
        backward = np.asarray(np.linalg.inv(forward), np.float64)
        for anchor, other, homography in ((a, b, forward), (b, a, backward)):
            laid = lay(views[anchor].prepared.sharp, views[other].prepared.sharp, homography)
            if laid is None:
                continue
            start = apply_homography(homography, views[anchor].corners)
            height, width = laid[1].shape
            inside = (start >= 0).all(axis=1) & (start[:, 0] <= width - 1) & (start[:, 1] <= height - 1)
            column, row = np.where(inside[:, None], start, 0.0).astype(int).T
            inside &= laid[1][row, column] > 0
            index = np.flatnonzero(inside)
            there, good = follow(laid[0], views[other].prepared.sharp, start[index], settings.follow)
            observed[anchor, other] = index[good], camera.pixel_to_normalized(there[good])
    return observed


@dataclass
class _Placed:
    """A placed frame: camera_optical to world, and its corners (N, 3) in the world, NaN where nothing is known."""

    rotation: Points
    position: Points
    points: Points


def _place(
    views: list[_View],
    homographies: dict[tuple[int, int], Points],
    observed: Observed,
    camera: CameraModel,
    settings: SequenceSettings,
) -> dict[int, _Placed]:
    """Poses of all frames that hang together with the first registered pair."""
    if not homographies:
        return {}
    first = min(homographies)[0]
    plane = _plane(homographies, first, camera)
    placed = {first: _on_plane(views[first], np.eye(3), np.zeros(3), plane)}
    for view in views[first + 1 :]:
        space, rays = _known(view.number, placed, observed)
        if len(space) < settings.min_placed:
            continue
        cv2.setRNGSeed(settings.registration.seed)
        done, turn, shift, inlier = cv2.solvePnPRansac(
            space,
            rays,
            np.eye(3),
            None,
            reprojectionError=6.0 / camera.fx,
            iterationsCount=300,
            flags=cv2.SOLVEPNP_SQPNP,
        )
        if not done or inlier is None or len(inlier) < settings.min_placed:
            continue
        kept = inlier.ravel()
        turn, shift = cv2.solvePnPRefineLM(space[kept], rays[kept], np.eye(3), None, turn, shift)
        rotation = cv2.Rodrigues(turn)[0].T
        position = -rotation @ shift.ravel()
        plane = _nearby_plane((space[kept] - position) @ rotation, plane)
        placed[view.number] = _on_plane(view, rotation, position, plane)
        _adjust(
            sorted(placed)[-settings.window :],
            views,
            placed,
            observed,
            camera,
            settings,
            (4.0, 1.0),
            settings.window_iterations,
        )
    return placed


def _known(number: int, placed: dict[int, _Placed], observed: Observed) -> tuple[Points, Points]:
    """Points in space (N, 3) and their rays (N, 2) in that frame, from frames that have a pose."""
    pairs = [(placed[anchor].points[i], rays) for (anchor, frame), (i, rays) in observed.items()
             if frame == number and anchor in placed]  # fmt: skip
    if not pairs:
        return np.empty((0, 3)), np.empty((0, 2))
    space, rays = (np.concatenate(part) for part in zip(*pairs, strict=True))
    known = np.isfinite(space).all(axis=1)
    return space[known], rays[known]


def _plane(homographies: dict[tuple[int, int], Points], first: int, camera: CameraModel) -> Points:
    """The scene's plane n·X = 1 in the first frame: n from the homography of the widest pair that has it.

    Of the two decompositions the one that looks at the plane more frontally: the other sees it along its surface.
    """
    second = max(b for a, b in homographies if a == first)
    matrix = np.ascontiguousarray(homographies[first, second])
    _, _, shifts, normals = cv2.decomposeHomographyMat(matrix, camera.matrix)
    if max(float(np.linalg.norm(shift)) for shift in shifts) < 0.01:
        return np.array([0.0, 0.0, 1.0])  # the camera only turned: any plane explains that
    return max((np.asarray(n, np.float64).ravel() for n in normals), key=lambda n: float(n[2]))


def _nearby_plane(local: Points, otherwise: Points) -> Points:
    """The plane n·X = 1 through known points (N, 3) in the frame's own axes: 1/z is linear in the picture."""
    ahead = local[local[:, 2] > 1e-3]
    if len(ahead) < 10:
        return otherwise
    rays = ahead / ahead[:, 2:]
    inverse_depth = 1.0 / ahead[:, 2]
    weight = np.ones(len(ahead))
    for _ in range(5):
        solved = np.linalg.lstsq(rays * weight[:, None], inverse_depth * weight, rcond=None)[0]
        plane = np.asarray(solved, np.float64)
        left = inverse_depth - rays @ plane
        weight = np.sqrt(1.0 / (1.0 + (left / (np.median(np.abs(left)) * 2.0 + 1e-9)) ** 2))
    return plane


def _on_plane(view: _View, rotation: Points, position: Points, plane: Points) -> _Placed:
    rays = np.column_stack((view.rays, np.ones(len(view.rays))))
    inverse_depth = rays @ plane
    local = rays / np.where(inverse_depth > 1e-3, inverse_depth, np.nan)[:, None]
    return _Placed(rotation, position, local @ rotation.T + position)


def _adjust(
    numbers: list[int],
    views: list[_View],
    placed: dict[int, _Placed],
    observed: Observed,
    camera: CameraModel,
    settings: SequenceSettings,
    factors: tuple[float, ...],
    iterations: int,
) -> None:
    """Bundle adjustment of these frames in place. The first factors forgive more: the plane is but a first guess."""
    if len(numbers) < 2:
        return
    scene, kept = _scene(numbers, views, placed, observed, settings)
    for factor in factors:
        scene = adjust(scene, factor * settings.scale_px / camera.fx, iterations)
    begin = 0
    for row, number in enumerate(numbers):
        frame, count = placed[number], int(kept[row].sum())
        frame.rotation, frame.position = scene.rotations[row], scene.translations[row]
        frame.points[kept[row]] = scene.points[begin : begin + count]
        begin += count


def _scene(
    numbers: list[int], views: list[_View], placed: dict[int, _Placed], observed: Observed, settings: SequenceSettings
) -> tuple[Scene, list[NDArray[np.bool_]]]:
    """All corners of these frames that were followed far enough, with each of the frames that saw them.

    Beside it, for every frame, which of its corners (N,) are in the scene.
    """
    row = {number: index for index, number in enumerate(numbers)}
    frame, point, seen, space, chosen = [], [], [], [], []
    begin = 0
    for anchor in numbers:
        view, points = views[anchor], placed[anchor].points
        others = [(row[o], *found) for (a, o), found in observed.items() if a == anchor and o in row]
        count = np.zeros(len(points), int)
        for _, index, _ in others:
            count[index] += 1
        kept = (count >= settings.min_seen) & np.isfinite(points).all(axis=1)
        number_of = np.full(len(points), -1)
        number_of[kept] = begin + np.arange(kept.sum())
        begin += int(kept.sum())
        space.append(points[kept])
        chosen.append(kept)
        for place, index, rays in [(row[anchor], np.arange(len(points)), view.rays), *others]:
            use = kept[index]
            frame.append(np.full(int(use.sum()), place))
            point.append(number_of[index[use]])
            seen.append(rays[use])
    scene = Scene(
        np.stack([placed[n].rotation for n in numbers]),
        np.stack([placed[n].position for n in numbers]),
        np.concatenate(space),
        np.concatenate(frame),
        np.concatenate(point),
        np.concatenate(seen),
    )
    return scene, chosen
