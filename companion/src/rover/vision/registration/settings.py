"""What registration may be told: how it looks for a homography, and what it takes to believe one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from rover.vision.registration.blobs import BlobSettings
from rover.vision.registration.cluster import EPSILON_PX, MIN_POINTS
from rover.vision.registration.features import FeatureSettings
from rover.vision.registration.matching import MatchSettings
from rover.vision.registration.preprocess import PreprocessSettings
from rover.vision.registration.refine import RefineSettings

Cluster = Literal["displacement", "position", "none"]
Estimator = Literal["magsac", "ransac"]

# The paper's ε as a share of its picture's width; it clusters by position.
PAPER_EPSILON = EPSILON_PX / 320.0


@dataclass(frozen=True)
class RegistrationSettings:
    """features: ORB's. blobs: SIFT's, asked where ORB's lead to nothing and `use_blobs` allows it.

    cluster: DBSCAN on matches by position and displacement, by position in each picture as in the paper, or none.

    epsilon: of DBSCAN, a share of the picture's width; min_points: its core points.
    estimator: OpenCV's USAC_MAGSAC, or its plain RANSAC.
    inlier_px: how far a match may lie from where the homography puts it.

    min_inliers, min_ratio: fewer agreeing matches, or a smaller share of all clustered ones, is a refusal.
    min_spread: the inliers' bounding box, as a share of each picture's area.
    one_scale: factor by which the pictures' scales may differ before the finer one is made smaller.
    fine: in which sizes of the pictures (halvings, the smallest first) the homography is made exact.
    min_kept: share of as many matches as before that must agree after the refinement; with fewer it is not used.
    rival: share of as many matches that may agree with another place: of two windows that look alike, which is it?
    min_overlap: share of each picture that must lie in the other: beyond, the homography is a guess.
    min_overlap_zoomed: where their scales differ by more than `one_scale`, of the finer picture in the coarser.
    min_agreement: see `agreement`.
    coarse: of the way by a similarity: how far a match may lie from where it is put, a share of B's width;
    coarse_inliers: matches that must agree so far; coarse_rival: share of as many that may agree with something
    else; coarse_kept: with the refined homography, to `inlier_px`.
    coarse_overlap, coarse_agreement, coarse_apart: what it takes to believe it alone: share that each picture must
    have of the other, agreement, and the share of the picture that may disagree nevertheless.
    better: by how much its agreement must be the higher for it to be preferred.
    contradiction: of `register`: how far A's corners may come back from where they were, the way to B and back, mean,
    a share of A's width.
    """

    preprocess: PreprocessSettings = field(
        default_factory=lambda: PreprocessSettings(fixed_pattern=False, dead_pixels=False, clahe_clip=2.0)
    )
    features: FeatureSettings = field(
        default_factory=lambda: FeatureSettings(
            count=1200, surplus=2, columns=12, rows=9, levels=8, scale=1.2, patch=31, threshold_start=20
        )
    )
    blobs: BlobSettings = field(default_factory=BlobSettings)
    use_blobs: bool = True
    match: MatchSettings = field(default_factory=lambda: MatchSettings(max_distance=72.0, ratio=0.85))
    cluster: Cluster = "displacement"
    epsilon: float = 40.0 / 320.0
    min_points: int = MIN_POINTS
    estimator: Estimator = "magsac"
    inlier_px: float = 3.0
    min_inliers: int = 14
    min_ratio: float = 0.28
    min_spread: float = 0.01
    one_scale: float = 1.4
    refine: RefineSettings = field(default_factory=RefineSettings)
    fine: tuple[int, ...] = (1, 0)
    min_kept: float = 0.6
    rival: float = 0.5
    min_overlap: float = 0.4
    min_overlap_zoomed: float = 0.6
    min_agreement: float = 0.5
    coarse: float = 0.0125
    coarse_inliers: int = 10
    coarse_rival: float = 0.3
    coarse_kept: int = 6
    coarse_overlap: float = 0.5
    coarse_agreement: float = 0.45
    coarse_apart: float = 0.25
    better: float = 0.03
    contradiction: float = 0.05
    seed: int = 1
