"""`rover register`: where one picture lies in another."""

from __future__ import annotations

import time
from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.cli.pictures import DEFAULT_STEPS, STEPS_HELP

if TYPE_CHECKING:
    from rover.vision.registration.register import Registration

HELP = """Register two thermal or visible pictures: a homography from A to B, or a refusal.

Prints `failed` with the reason when the pictures do not fit; the exit code is 0 then too, since the question is
answered.

\b
Examples:
  rover register a.tif b.tif
  rover register graf/img1.png graf/img2.png --json | jq .homography
  rover register a.tif b.tif --cluster position --estimator ransac
  rover register a.tif b.tif --steps fixed-pattern,dead-pixels,gaussian,stretch,clahe
  rover register clip.cptv clip.cptv?skip=20
"""


class ClusterName(str, Enum):
    """What matched keypoints are clustered by."""

    DISPLACEMENT = "displacement"
    POSITION = "position"


class EstimatorName(str, Enum):
    """What finds a homography among clustered matches."""

    MAGSAC = "magsac"
    RANSAC = "ransac"


def command(
    a: Annotated[str, typer.Argument(metavar="A", help="Picture, 8 or 16 bits, or a source: its first frame.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Picture, 8 or 16 bits, or a source: its first frame.")],
    cluster: Annotated[
        ClusterName, typer.Option(help="What DBSCAN groups matches by; position, ε 20 px of 320, is the paper's.")
    ] = ClusterName.DISPLACEMENT,
    estimator: Annotated[
        EstimatorName, typer.Option(help="OpenCV's USAC_MAGSAC, or its plain RANSAC.")
    ] = EstimatorName.MAGSAC,
    steps: Annotated[str, typer.Option(metavar="STEP,…", help=STEPS_HELP)] = DEFAULT_STEPS,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.pictures import read_picture
    from rover.vision.registration.register import PAPER_EPSILON, RegistrationSettings, register
    from rover.vision.registration.steps import split_steps, with_steps

    settings = RegistrationSettings(estimator=estimator.value)
    settings = replace(settings, preprocess=with_steps(settings.preprocess, split_steps(steps, "--steps")))
    picture_a, picture_b = read_picture(a), read_picture(b)
    if cluster is ClusterName.POSITION:
        settings = replace(settings, cluster="position", epsilon=PAPER_EPSILON)
    begin = time.perf_counter()
    found = register(picture_a, picture_b, settings)
    time_ms = (time.perf_counter() - begin) * 1e3
    if as_json:
        write_json(document(found, time_ms))
    else:
        write_text(text(found, time_ms))
    return 0


def document(found: Registration, time_ms: float) -> dict[str, Any]:
    """The registration as JSON; homography maps pixels (x, y, 1) of A to B, null when it failed."""
    return {
        "status": found.status,
        "reason": found.reason,
        "keypoints": list(found.keypoints),
        "matches": found.matches,
        "clustered": found.clustered,
        "inliers": found.inliers,
        "homography": None if found.homography is None else found.homography.tolist(),
        "rmse_before_px": found.rmse_before,
        "rmse_after_px": found.rmse_after,
        "agreement": found.agreement,
        "time_ms": round(time_ms, 3),
    }


def text(found: Registration, time_ms: float) -> str:
    """The registration for a person."""
    counts = (
        f"{found.keypoints[0]} and {found.keypoints[1]} keypoints, {found.matches} matches, "
        f"{found.clustered} clustered, {found.inliers} inliers, {time_ms:.0f} ms"
    )
    if found.homography is None:
        return f"failed: {found.reason}\n{counts}"
    rows = "\n".join("  " + "  ".join(f"{value:14.8g}" for value in row) for row in found.homography)
    return f"ok: RMSE {found.rmse_before:.2f} px before, {found.rmse_after:.2f} px after\n{counts}\n{rows}"
