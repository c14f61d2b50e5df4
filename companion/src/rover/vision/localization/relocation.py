"""Where is the rover, when nothing is believed about it? All keyframes are asked at once, and two frames must agree.

Each feature of the frame votes for the keyframe that holds its nearest descriptor; the few with most votes are matched
in full. A place is proposed only if many matches agree that spread over the ground: one hot stone looks like another,
a patch of ground as large as a table does not. It is believed once the next frame proposes the same place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover.geometry import Pose2, wrap_angle
from rover.vision.camera.model import CameraModel
from rover.vision.localization.ground_pose import GroundPose
from rover.vision.localization.keyframes import KeyframeStore
from rover.vision.localization.observation import Mark, Observation, no_mark
from rover.vision.localization.placement import Placement, PlacementSettings, place


@dataclass(frozen=True)
class RelocationSettings:
    """voters: features that vote. vote_bits: bits in which a vote's descriptors may differ. asked: keyframes matched.

    inliers, share, extent: what it takes to propose a place: agreeing matches, their share of all matches, and their
    spread in metres (standard deviation across). agree, agree_turn: metres and radians within which two proposals are
    the same place. memory: seconds after which a proposal is forgotten.
    """

    voters: int = 120
    vote_bits: float = 60.0
    asked: int = 3
    inliers: int = 20
    share: float = 0.3
    extent: float = 0.07
    agree: float = 0.05
    agree_turn: float = 0.05
    memory: float = 1.0


@dataclass(frozen=True, eq=False)
class Proposal:
    """The rover was seen at `found` in the frame of keyframe `index`; place: the same in the frame of that submap.

    travelled: where the wheels (or whatever predicts motion) had the rover at that time, in a frame of their own.
    """

    time: float
    submap: int
    index: int
    found: GroundPose
    matches: int
    place: Pose2
    travelled: Pose2


def propose(
    time: float,
    seen: Observation,
    known: tuple[int, KeyframeStore],
    poses: NDArray[np.float64],
    travelled: Pose2,
    camera: CameraModel,
    placement: PlacementSettings,
    settings: RelocationSettings,
    mark: Mark = no_mark,
) -> Proposal | None:
    """The place that the frame shows, if a submap knows it.

    known: the submap's number and its keyframes; poses: theirs in its frame, (K, 3).
    """
    submap, keyframes = known
    # Every third feature or so: they come in the order of their place in the picture.
    every = max(1, math.ceil(len(seen) / settings.voters))
    votes = keyframes.votes(seen.descriptors[::every], settings.vote_bits)
    best: Proposal | None = None
    for index in np.argsort(-votes, kind="stable")[: settings.asked].tolist():
        made = place(seen, keyframes.frames[index], camera, None, placement, mark)
        found = made.found
        if found is None or not convincing(made, settings) or (best is not None and found.count <= best.found.count):
            continue
        at = Pose2(*poses[index].tolist()).compose(found.pose)
        best = Proposal(time, submap, index, found, made.matches, at, travelled)
    return best


def convincing(made: Placement, settings: RelocationSettings) -> bool:
    """True when enough matches agree, over enough ground, that no single hot stone can be behind it."""
    found = made.found
    if found is None or found.count < settings.inliers or found.count < settings.share * made.matches:
        return False
    return made.extent >= settings.extent


def same_place(a: Proposal, b: Proposal, blind_speed: float, blind_turn: float, settings: RelocationSettings) -> bool:
    """True when `b` is where `a` and the motion between them say; blind_*: motion that nothing has measured."""
    apart = b.time - a.time
    if a.submap != b.submap:
        return False
    if not 0.0 < apart <= settings.memory:
        return False
    expected = a.place.compose(b.travelled.relative_to(a.travelled))
    turn = abs(wrap_angle(expected.heading - b.place.heading))
    return (
        expected.distance(b.place) <= settings.agree + blind_speed * apart
        and turn <= settings.agree_turn + blind_turn * apart
    )
