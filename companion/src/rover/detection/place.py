"""One place on the ground that may hold a mine, and what all looks at it together say."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rover.detection.classifier import CLASSES
from rover.geometry import Pose2

if TYPE_CHECKING:
    from rover.detection.evidence_settings import EvidenceSettings
    from rover.detection.ground.detect import Detection

# Share of each class among candidates, as one look knows it beforehand.
PRIOR = {"obstacle": 0.2, "surface": 0.1, "buried": 0.15, "background": 0.55}
# One look may not decide alone, and no place is ever beyond doubt.
MIN_PROBABILITY = 0.03
MAX_LOG_RATIO = 6.0
# All looks at one place share its soil and its model's errors: together they never weigh more than so many.
MAX_LOOKS = 4.0
_PRIOR_VALUES = np.array([PRIOR[name] for name in CLASSES])
# Viewpoints that differ by less than this (metres, radians) are the same one.
VIEW_STEP, VIEW_TURN = 0.12, 0.25
# A place below this probability of being a mine after SPENT_LOOKS looks is forgotten.
SPENT, SPENT_LOOKS = 0.02, 4


@dataclass(frozen=True)
class Anchor:
    """When something was seen, seconds, and where in map the rover believes to have been then."""

    time: float
    pose: Pose2


@dataclass(eq=False)
class Place:
    """A place in map. p: probability per class; views: looks that found it. sigma_m: 1σ of the position along one axis,
    among the ground around it.

    suspected: it may be a mine, keep away and look closer. indication: reported. earlier: what an earlier visit said
    of it, None where that has not reported it; nothing that a visit has reported is dropped. together: probability by
    the temperatures of both visits, None where they do not say it. submap, anchor: of the last look that
    found it; with that submap the place moves.
    """

    id: int
    x: float
    y: float
    first_seen: float
    last_seen: float
    sigma_m: float = 0.05
    p: dict[str, float] = field(default_factory=lambda: dict(PRIOR))
    views: int = 0
    extent: float = 0.0
    suspected: bool = False
    indication: bool = False
    looks: int = 0
    earlier: dict[str, float] | None = None
    together: float | None = None
    submap: int = 0
    anchor: Anchor | None = None
    _evidence: NDArray[np.float64] = field(default_factory=lambda: np.zeros(len(CLASSES)), repr=False)
    _weight: float = field(default=0.0, repr=False)
    _seen_from: dict[tuple[int, int, int], int] = field(default_factory=dict, repr=False)
    _sums: NDArray[np.float64] = field(default_factory=lambda: np.zeros(4), repr=False)
    _pose_variance: float = field(default=math.inf, repr=False)

    @property
    def mine_probability(self) -> float:
        """Probability of a mine of either kind."""
        return self.p["surface"] + self.p["buried"]

    @property
    def kind(self) -> str:
        """'surface' or 'buried', whichever is more probable."""
        return "surface" if self.p["surface"] > self.p["buried"] else "buried"

    @property
    def reported_as(self) -> tuple[str, float]:
        """Kind and probability as reported: by this visit, an earlier one or both together, whichever is surest."""
        best = max((self.p, self.earlier or self.p), key=lambda p: max(p["surface"], p["buried"]))
        kind = "surface" if best["surface"] > best["buried"] else "buried"
        return kind, max(best[kind], self.together or 0.0)

    @property
    def is_spent(self) -> bool:
        """True when enough looks have spoken against it."""
        return self.earlier is None and self.looks >= SPENT_LOOKS and self.mine_probability < SPENT

    def add(
        self,
        found: Detection,
        at: NDArray[np.float64],
        pose: Pose2,
        weight: float,
        variance: tuple[float, float],
        time: float,
        submap: int = 0,
    ) -> None:
        """A look that found something at `at` (map); variance: its own and the pose's, m²."""
        self.submap, self.anchor = submap, Anchor(time, pose)
        weight *= self._novelty(pose)
        self._learn(found.p, weight)
        likeness = found.p["surface"] + found.p["buried"]
        own, shared = variance
        # A look that takes it for something else says little about where the mine lies.
        share = weight * (0.05 + likeness) / (own + shared)
        self._sums += share * np.array([float(at[0]), float(at[1]), 1.0, found.extent])
        total = self._sums[2]
        self.x, self.y, self.extent = (float(self._sums[i] / total) for i in (0, 1, 3))
        self._pose_variance = min(self._pose_variance, shared)
        self.sigma_m = math.sqrt(1.0 / total + self._pose_variance)
        self.views += 1
        self.last_seen = time

    def move(self, shift: Pose2) -> None:
        """Its submap has moved in map by `shift`, and the place with it."""
        x, y = shift.transform(np.array([[self.x, self.y]]))[0].tolist()
        self.x, self.y = x, y
        self._sums[:2] = self._sums[2] * np.array([x, y])
        if self.anchor is not None:
            self.anchor = Anchor(self.anchor.time, shift.compose(self.anchor.pose))

    def miss(self, answer: dict[str, float], pose: Pose2, weight: float) -> None:
        """A look in clear view that found nothing here."""
        self._learn(answer, weight * self._novelty(pose))

    def absorb(self, other: Place) -> None:
        """Takes over the looks of a place that proved to be the same; the evidence of the better known one stays."""
        self._sums += other._sums
        self.x, self.y, self.extent = (float(self._sums[i] / self._sums[2]) for i in (0, 1, 3))
        self.first_seen = min(self.first_seen, other.first_seen)
        self.last_seen = max(self.last_seen, other.last_seen)
        self.earlier = self.earlier or other.earlier

    def judge(self, settings: EvidenceSettings) -> None:
        """Sets `suspected` and `indication`; a place that was suspected is dismissed only well below the threshold."""
        least = settings.suspect_threshold * (0.75 if self.suspected else 1.0)
        self.suspected = self.views >= settings.suspect_views and self.mine_probability >= least
        self.indication = self.is_found(settings) or self.earlier is not None or self.together is not None
        self.suspected = self.suspected or self.indication

    def is_found(self, settings: EvidenceSettings) -> bool:
        """Whether the looks of this visit alone report it."""
        return self.views >= settings.report_views and self.mine_probability >= settings.report_threshold

    def _novelty(self, pose: Pose2) -> float:
        """1 for a new viewpoint, less for every further look from the same one."""
        key = (
            math.floor(pose.x / VIEW_STEP),
            math.floor(pose.y / VIEW_STEP),
            math.floor(pose.heading / VIEW_TURN),
        )
        before = self._seen_from.get(key, 0)
        self._seen_from[key] = before + 1
        return 1.0 / (1.0 + 0.7 * before)

    def _learn(self, answer: dict[str, float], weight: float) -> None:
        values = np.array([max(answer[name], MIN_PROBABILITY) for name in CLASSES])
        self._evidence += weight * np.log(values / values.sum() / _PRIOR_VALUES)
        self._weight += weight
        log = np.log(_PRIOR_VALUES) + self._evidence / (1.0 + self._weight / MAX_LOOKS)
        e = np.exp(np.maximum(log - log.max(), -MAX_LOG_RATIO))
        self.p = dict(zip(CLASSES, (e / e.sum()).tolist(), strict=True))
        self.looks += 1
