"""All submaps of a run, and which of them the rover is in.

A submap is a filter over the rover and the keyframes of one piece of ground, small enough to be taken for rigid. A
frame costs what its submap costs, however many others there are. A new submap begins with its frame laid upon that of
the one before, so that until a loop is closed coordinates are the same in all of them, and in map.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2
from rover.vision.camera.model import CameraModel
from rover.vision.localization.keyframe_map import KeyframeMap, SubmapRecord
from rover.vision.localization.keyframes import OF_ANOTHER_RUN, KeyframeSettings, KeyframeStore
from rover.vision.localization.pose_filter import Moved, PoseFilter, relative_pose
from rover.vision.localization.submap_graph import SubmapGraph, Tie, edge_between

Array = NDArray[np.float64]

# Keyframes of other submaps farther from the rover than this, metres, can't show the ground in view.
IN_REACH_M = 2.2
# 1σ of x, y (m) and heading of the rover in a submap that begins where it stands: as good as exact, and invertible.
EXACT = (1e-4, 1e-4, 1e-4)


@dataclass(eq=False)
class Submap:
    """The filter's rover is where the rover was when it was last in this submap."""

    filter: PoseFilter
    keyframes: KeyframeStore


@dataclass(frozen=True, eq=False)
class Known:
    """A keyframe of another submap that shows the ground in view: where the rover is expected in its frame.

    covariance (3, 3) in the keyframe's axes. overlap: the share of the view that it shows.
    """

    submap: int
    index: int
    overlap: float
    expected: Pose2
    covariance: Array


class Atlas:
    """At least one submap. Raises nothing; submaps are numbered in the order in which they were begun."""

    def __init__(
        self,
        camera: CameraModel,
        settings: KeyframeSettings,
        start: Pose2,
        sigma: tuple[float, float, float],
        motion_sigma: tuple[float, float],
        mount_sigma: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self._mount_sigma = mount_sigma
        self._camera, self._settings = camera, settings
        self.graph = SubmapGraph(start, sigma)
        self.submaps = [Submap(PoseFilter(start, EXACT, motion_sigma, mount_sigma), KeyframeStore(camera, settings))]
        self.active = 0
        # Of the submaps that the rover has not been in since they were last asked for.
        self._records: dict[int, SubmapRecord] = {}
        # Grows with every move of submaps against each other.
        self.moves = 0

    @property
    def here(self) -> Submap:
        """The submap that the rover is in."""
        return self.submaps[self.active]

    def begin(self) -> None:
        """A new submap where the rover is now."""
        self._records.pop(self.active, None)
        before = self.here.filter
        fresh = PoseFilter(before.pose, EXACT, (0.0, 0.0))
        fresh.take_motion(before)
        edge = edge_between(
            self.active, (before.pose, before.pose_covariance), len(self.submaps), (before.pose, fresh.pose_covariance)
        )
        self.graph.begin(edge)
        self.submaps.append(Submap(fresh, KeyframeStore(self._camera, self._settings)))
        self.here.keyframes.forget_votes()
        self.active = len(self.submaps) - 1

    def elsewhere(self, least: float) -> list[Known]:
        """Keyframes of other submaps that share at least this much of the view, the best of each; best first."""
        robot = self.here.filter
        place, _ = self.graph.lifted(self.active, robot.pose, robot.pose_covariance)
        found: list[Known] = []
        for number, submap in enumerate(self.submaps):
            if number == self.active or not len(submap.keyframes):
                continue
            poses = submap.filter.keyframe_poses()
            rough = place.relative_to(self.graph.poses[number])
            near = np.flatnonzero(np.hypot(poses[:, 0] - rough.x, poses[:, 1] - rough.y) < IN_REACH_M)
            if not len(near):
                continue
            pose = np.array([rough.x, rough.y, rough.heading])
            overlap = submap.keyframes.overlap(pose, poses[near])
            best = int(overlap.argmax())
            if overlap[best] < least:
                continue
            index = int(near[best])
            inside, covariance = self.graph.carried(self.active, robot.pose, robot.pose_covariance, number)
            expected, of_pose, of_key = relative_pose(inside, submap.filter.keyframe_pose(index))
            key = submap.filter.covariance_of(index)
            spread = of_pose @ covariance @ of_pose.T + of_key @ key @ of_key.T
            found.append(Known(number, index, float(overlap[best]), expected, spread))
        return sorted(found, key=lambda known: (-known.overlap, known.submap))

    def enter(self, number: int, index: int, fix: Pose2, noise: Array, sure: bool) -> None:
        """The rover goes over into a submap: it was seen at `fix` in the frame of keyframe `index` there.

        sure: its pose in the submap that it leaves is known, too; what that says of the two is taken in, and all
        submaps are moved to where they fit best.
        """
        left, before = self.active, self.here.filter
        self._records.pop(left, None)
        inside = self.submaps[number].filter
        if number != left:
            inside.take_motion(before)
            self.here.keyframes.forget_votes()
        inside.relocate(index, fix, noise)
        self.active = number
        if not sure:
            return
        edge = edge_between(left, (before.pose, before.pose_covariance), number, (inside.pose, inside.pose_covariance))
        if not self.graph.knows(edge):
            self.graph.close(edge)
            self.moves += 1

    def tie(self, point: tuple[float, float], sigma: float, known: tuple[float, float]) -> None:
        """The rover, where the filter has it, sees at `point` in base_link, with 1σ, a point that is known in map."""
        pose, covariance = self.here.filter.pose, self.here.filter.pose_covariance
        x, y = pose.transform(np.array([point]))[0].tolist()
        by_pose = np.array([[1.0, 0.0, pose.y - y], [0.0, 1.0, x - pose.x]])
        spread = by_pose @ covariance @ by_pose.T + np.eye(2) * sigma**2
        if self.graph.tie(Tie(self.active, (x, y), known, spread)):
            self.moves += 1

    def as_seen_with(self, point: tuple[float, float], number: int, moved: Moved) -> tuple[float, Pose2, Array] | None:
        """The rover as `moved` since the filter's time, in the frame of the first keyframe of a submap with a point.

        point: in map. Returns the keyframe's time, the pose, and the covariance (2, 2) of its position.
        """
        submap = self.submaps[number]
        x, y = self.graph.poses[number].inverse().transform(np.array([point]))[0].tolist()
        index = submap.keyframes.first_with((x, y), submap.filter.keyframe_poses())
        if index is None:
            return None
        time, key = submap.keyframes.frames[index].time, submap.filter.keyframe_pose(index)
        robot = Pose2(*moved.robot[:3].tolist())
        if number == self.active:
            covariance = self.here.filter.relative_covariance(index, moved)
            return time, robot.relative_to(key), covariance[:2, :2]
        own = (moved.jacobian @ self.here.filter.robot_covariance @ moved.jacobian.T + moved.added)[:3, :3]
        inside, spread = self.graph.carried(self.active, robot, own, number)
        relative, of_pose, of_key = relative_pose(inside, key)
        covariance = of_pose @ spread @ of_pose.T + of_key @ submap.filter.covariance_of(index) @ of_key.T
        return time, relative, covariance[:2, :2]

    def spread_of(self, point: tuple[float, float], number: int) -> Array:
        """Covariance (2, 2) in map of a point of the map that is held by a submap: of the submap, and of what lies in
        it."""
        base, submap = self.graph.poses[number], self.submaps[number]
        x, y = base.inverse().transform(np.array([point]))[0].tolist()
        own = np.zeros((3, 3))
        if len(submap.keyframes):
            poses = submap.filter.keyframe_poses()
            own = submap.filter.covariance_of(int(np.hypot(poses[:, 0] - x, poses[:, 1] - y).argmin()))
        return self.graph.lifted(number, Pose2(x, y, 0.0), own)[1][:2, :2]

    @property
    def map(self) -> KeyframeMap:
        """All keyframes as they are believed to lie, for a next run."""
        for number, one in enumerate(self.submaps):
            if number == self.active or number not in self._records:
                poses, covariance = one.filter.keyframe_poses().copy(), one.filter.keyframe_covariance
                self._records[number] = SubmapRecord(list(one.keyframes.frames), poses, covariance)
        records = [self._records[number] for number in range(len(self.submaps))]
        graph = self.graph
        return KeyframeMap(
            records,
            list(graph.poses),
            list(graph.edges),
            list(graph.ties),
            graph.launch,
            graph.sigma,
            self.active,
            self.here.filter.mount,
        )

    def restore(
        self, known: KeyframeMap, motion_sigma: tuple[float, float], nowhere: tuple[float, float, float]
    ) -> None:
        """Takes over another run's submaps; the rover is somewhere in them, with 1σ `nowhere`."""
        self.graph = SubmapGraph(known.launch, known.sigma)
        self.graph.poses = list(known.submap_poses)
        self.graph.edges, self.graph.ties = list(known.edges), list(known.ties)
        self.graph.solve()
        self.submaps, self._records = [], {}
        for record in known.submaps:
            estimate = PoseFilter(known.launch, nowhere, motion_sigma, self._mount_sigma)
            if known.mount is not None:
                estimate.mount = known.mount
            estimate.add_known(record.poses, record.covariance)
            store = KeyframeStore(self._camera, self._settings)
            for frame in record.frames:
                store.add(replace(frame, time=OF_ANOTHER_RUN))
            self.submaps.append(Submap(estimate, store))
        self.active = known.active
