"""`rover locate`: a pixel's place on the ground, or a ground point's pixel."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.errors import BadInput

HELP = """Where on flat ground does a pixel look, or in which pixel does a ground point appear (equations 7 to 11)?

Ground points are metres of base_link: x ahead, y to the left, the origin on the ground between the wheels. Pixel 0,0 is
the centre of the upper left one. sigma is carried through the camera to first order: how well the pixel is read, and
how well the mount's angles and height are known.

\b
Examples:
  rover locate --camera lepton-160 --pixel 80,100
  rover locate --camera camera.toml --pixel 80,100 --sigma-deg 0.5 --json | jq .sigma_m
  rover locate --camera camera.toml --ground 1.2,-0.3
"""


def command(
    camera: Annotated[str, typer.Option("--camera", metavar="CAMERA", help="Camera TOML with [mount], or a name.")],
    pixel: Annotated[str | None, typer.Option("--pixel", metavar="U,V", help="Column and row, pixels.")] = None,
    ground: Annotated[str | None, typer.Option("--ground", metavar="X,Y", help="A point of base_link, m.")] = None,
    sigma_px: Annotated[float, typer.Option(min=0.0, help="How well a pixel is read, 1 sigma, pixels.")] = 0.5,
    sigma_deg: Annotated[float, typer.Option(min=0.0, help="Of the mount's roll, pitch and yaw, each, °.")] = 0.0,
    sigma_height_m: Annotated[float, typer.Option(min=0.0, help="Of the camera's height, m.")] = 0.0,
    sigma_m: Annotated[float, typer.Option(min=0.0, help="Of a point given by --ground, each axis, m.")] = 0.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    import numpy as np

    from rover.vision.calibration.uncertainty import UncertainCamera
    from rover.vision.camera.file import load_camera

    if (pixel is None) == (ground is None):
        raise BadInput("locate: give one of --pixel U,V and --ground X,Y")
    model = load_camera(camera)
    angle = math.radians(sigma_deg)
    uncertain = UncertainCamera(
        model, ("roll", "pitch", "yaw", "z"), np.diag(np.square([angle, angle, angle, sigma_height_m]))
    )
    if pixel is not None:
        at = np.array([pair("--pixel", pixel)])
        if not model.inside(at)[0]:
            raise BadInput(f"--pixel {pixel}: outside of the picture of {model.name}, {model.width}×{model.height}")
        places, covariances = uncertain.pixel_to_ground(at, sigma_px)
        if not np.isfinite(places).all():
            raise BadInput(f"--pixel {pixel}: at or above the horizon of {model.name}: it shows no ground")
        found, across, along = _axes(covariances[0])
        answer = {"x": float(places[0, 0]), "y": float(places[0, 1]), "sigma_m": found,
                  "sigma_x_m": across, "sigma_y_m": along}  # fmt: skip
        line = f"{answer['x']:.3f} m ahead, {answer['y']:.3f} m to the left, 1 sigma {found * 100:.1f} cm"
    else:
        assert ground is not None
        at = np.array([pair("--ground", ground)])
        spread = np.broadcast_to(sigma_m**2 * np.eye(2), (1, 2, 2))
        pixels, covariances = uncertain.ground_to_pixel(at, spread)
        if not np.isfinite(pixels).all() or not model.inside(pixels)[0]:
            raise BadInput(f"--ground {ground}: {model.name} does not see that point")
        total, across, along = _axes(covariances[0] + sigma_px**2 * np.eye(2))
        answer = {"u": float(pixels[0, 0]), "v": float(pixels[0, 1]), "sigma_px": total,
                  "sigma_u_px": across, "sigma_v_px": along}  # fmt: skip
        line = f"pixel {answer['u']:.2f}, {answer['v']:.2f}, 1 sigma {total:.2f} px"
    if as_json:
        write_json(answer)
    else:
        write_text(line)
    return 0


def pair(option: str, text: str) -> tuple[float, float]:
    """Two finite numbers. Raises BadInput."""
    parts = text.split(",")
    try:
        first, second = map(float, parts)
    except ValueError:
        first = second = math.nan
    if not (math.isfinite(first) and math.isfinite(second)):
        raise BadInput(f"{option} {text}: two numbers with a comma between them are expected")
    return first, second


def _axes(covariance: Any) -> tuple[float, float, float]:
    """The largest standard deviation in any direction, and those along both axes."""
    import numpy as np

    largest = float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))
    return largest, float(np.sqrt(covariance[0, 0])), float(np.sqrt(covariance[1, 1]))
