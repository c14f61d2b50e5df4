"""How the localizer is tuned."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from rover.vehicle import STANDARD
from rover.vision.localization.keyframes import KeyframeSettings
from rover.vision.localization.motion_model import FreeMotionNoise, GyroNoise, MotionNoise
from rover.vision.localization.placement import PlacementSettings
from rover.vision.localization.relocation import RelocationSettings
from rover.vision.registration.features import FeatureSettings
from rover.vision.registration.preprocess import PreprocessSettings

# 1σ of x, y (m) and heading (rad) while the place is not known at all: more than any field that is mapped.
NOWHERE = (10.0, 10.0, 3.0)


@dataclass(frozen=True)
class LocalizerSettings:
    """motion: what moves the pose between frames, the wheels or nothing but frames.

    gate: squared Mahalanobis distance up to which a pose is believed (99.9 % of three degrees of freedom).
    floor: 1σ of x, y (m) and heading (rad) that no single frame is better than. blur: the same of a keyframe's own
    features, shared by all fixes against it; blur_alone: without wheels that hold keyframes together.
    doubt: the same, added for each frame that contradicts what is believed.
    lost_after: contradicting frames in a row after which the rover counts as lost.
    mount: 1σ of the camera's offset along either axis of base_link, metres, and of the share by which it shows ways too
    long: half a degree of pitch shifts ground by 1 cm and stretches ways by 1.4 %.
    rigid: 1σ of the rover's place in its submap, metres, up to which that may be taken for rigid; beyond it a new one
    begins.
    """

    motion: Literal["wheels", "frames"] = "wheels"
    track_width: float = STANDARD.track_width
    gate: float = 16.3
    floor: tuple[float, float, float] = (0.0015, 0.0015, 0.0017)
    blur: tuple[float, float, float] = (0.0022, 0.0022, 0.0038)
    blur_alone: tuple[float, float, float] = (0.005, 0.005, 0.0085)
    doubt: tuple[float, float, float] = (0.02, 0.02, 0.02)
    lost_after: int = 3
    rigid: float = 0.03
    mount: tuple[float, float] = (0.012, 0.02)
    max_lag: float = 1.0
    preprocess: PreprocessSettings = field(default_factory=lambda: PreprocessSettings(gaussian_sigma=0.7))
    features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=160, levels=1, surplus=2))
    keyframe_features: FeatureSettings = field(default_factory=lambda: FeatureSettings(count=400, levels=1, surplus=2))
    placement: PlacementSettings = field(default_factory=PlacementSettings)
    relocation: RelocationSettings = field(default_factory=RelocationSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    noise: MotionNoise = field(default_factory=MotionNoise)
    gyro: GyroNoise = field(default_factory=GyroNoise)
    free_noise: FreeMotionNoise = field(default_factory=FreeMotionNoise)

    @property
    def mount_sigma(self) -> tuple[float, float]:
        """1σ of the camera's offset and stretch; frames alone cannot tell them."""
        return self.mount if self.motion == "wheels" else (0.0, 0.0)

    @property
    def motion_sigma(self) -> tuple[float, float]:
        """Standard deviations of the two numbers of motion while nothing is known."""
        if self.motion == "wheels":
            return self.noise.slip_start, self.noise.slip_start
        return self.free_noise.speed, self.free_noise.turn
