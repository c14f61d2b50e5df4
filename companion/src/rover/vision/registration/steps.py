"""The preprocessing steps of the paper (section 3.1.1) by name, as `--steps` and a mission's `preprocess` give them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from rover.errors import BadInput
from rover.vision.registration.preprocess import PreprocessSettings

# In the order in which they run; `stretch` is the contrast stretch, `equalizeHist` what OpenCV calls so.
STEPS = ("fixed-pattern", "dead-pixels", "gaussian", "stretch", "equalizeHist", "clahe")
# Those that a mission's frames go through unless it says otherwise.
LOCALIZATION_STEPS = ("fixed-pattern", "dead-pixels", "gaussian", "stretch", "clahe")
# Of the step `gaussian`, pixels.
GAUSSIAN_SIGMA = 0.7
# Of the step `clahe` where the settings left it out.
CLAHE_CLIP = 2.0


def split_steps(text: str, where: str) -> list[str]:
    """`a,b` as a list, `none` as an empty one. Raises BadInput naming `where` for a step that there is not."""
    wanted = [] if text == "none" else [name.strip() for name in text.split(",")]
    check_steps(wanted, f"{where} {text}")
    return wanted


def check_steps(wanted: Collection[str], where: str) -> None:
    """Raises BadInput for a step that there is not."""
    for name in wanted:
        if name not in STEPS:
            raise BadInput(f"{where}: {name!r} is no step; there is {', '.join(STEPS)}, or none of them: none")


def with_steps(settings: PreprocessSettings, wanted: Collection[str]) -> PreprocessSettings:
    """The settings with these steps and no others."""
    return replace(
        settings,
        fixed_pattern="fixed-pattern" in wanted,
        dead_pixels="dead-pixels" in wanted,
        gaussian_sigma=(settings.gaussian_sigma or GAUSSIAN_SIGMA) if "gaussian" in wanted else 0.0,
        stretch="stretch" in wanted,
        equalize="equalizeHist" in wanted,
        clahe_clip=(settings.clahe_clip or CLAHE_CLIP) if "clahe" in wanted else 0.0,
    )
