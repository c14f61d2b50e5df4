"""`rover calibrate`: a camera's intrinsics, its mount, or a pair of cameras, into the camera file that others read."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.out_file import spare_inputs
from rover.cli.output import say, write_json, write_text
from rover.cli.pictures import SOURCE, SOURCE_HELP, expanded, shots
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.vision.calibration.board import Board
    from rover.vision.calibration.intrinsics import Calibration, Freedom
    from rover.vision.camera.model import CameraModel

HELP = """Calibrate a thermal or visible camera; docs/guide/calibrating.md says how to make and heat a board.

\b
Examples:
  rover calibrate board/*.png --board 8x5 --square 0.04 --out camera.toml        inner corners of a checkerboard
  rover calibrate board/*.png --board 7x5 --square 0.05 --circles --out camera.toml
  rover calibrate board/*.png --board 4x11 --square 0.02 --circles --out camera.toml   staggered: M between rows
  rover calibrate box/*.png --box 0.335x0.225 --out camera.toml                  focal length only
  rover calibrate --fov 45x34 --size 320x240 --out camera.toml                   from the data sheet (eq. 9, 10)
  rover calibrate --camera camera.toml --ground points.csv --out camera.toml     its mount: u,v,x,y a line
  rover calibrate thermal/*.png --camera thermal.toml --board 8x5 --square 0.04 \\
      --second visible --second-camera visible.toml                              the pair, by a board seen by both
"""
EXCLUSIVE = "calibrate: one of --board, --box, --fov or --ground says what to calibrate from"


def command(
    images: Annotated[list[str] | None, typer.Argument(metavar=f"{SOURCE}…", help=SOURCE_HELP)] = None,
    board: Annotated[str | None, typer.Option(metavar="COLSxROWS", help="Inner corners, or circles, a side.")] = None,
    square: Annotated[float | None, typer.Option(metavar="M", help="Metres between neighbouring points.")] = None,
    circles: Annotated[
        bool, typer.Option("--circles", help="The board is a grid of circles, square or staggered (asymmetric).")
    ] = False,
    box: Annotated[str | None, typer.Option(metavar="WxH", help="Metres of a box's face as the only target.")] = None,
    fov: Annotated[str | None, typer.Option(metavar="HxV", help="Angles of view in degrees.")] = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels of the picture, with --fov.")] = None,
    camera: Annotated[str | None, typer.Option(metavar="C", help="A camera whose intrinsics are known.")] = None,
    ground: Annotated[Path | None, typer.Option(metavar="CSV", help="Points on the ground: u,v,x,y.")] = None,
    second: Annotated[Path | None, typer.Option(metavar="DIR", help="The other camera's pictures, by name.")] = None,
    second_camera: Annotated[str | None, typer.Option(metavar="C", help="The other camera.")] = None,
    distortion: Annotated[int, typer.Option(min=0, max=5, help="How many of k1, k2, p1, p2, k3.")] = 4,
    skew: Annotated[bool, typer.Option("--skew", help="Estimate the skew too.")] = False,
    name: Annotated[str, typer.Option(help="The camera's name.")] = "camera",
    out: Annotated[Path | None, typer.Option(metavar="CAMERA.toml", help="Where to write the camera.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.vision.calibration.board import Board
    from rover.vision.calibration.intrinsics import Freedom
    from rover.vision.camera.file import load_camera

    if sum(option is not None for option in (board, box, fov, ground)) != 1:
        raise BadInput(EXCLUSIVE)
    files = expanded(images or [])
    if out is not None:
        spare_inputs(out, [*map(Path, files), *([ground] if ground is not None else [])])
        if out.suffix.lower() != ".toml":
            raise BadInput(f"--out {out}: a camera's file ends in .toml")
    target = None
    if board is not None:
        if square is None:
            raise BadInput("calibrate: --square M, the metres between neighbouring points, is needed with --board")
        columns, rows = _pair(board, "--board", whole=True)
        target = Board(int(columns), int(rows), square, circles)
    if ground is not None:
        model, found = _mounted(camera, ground)
    elif fov is not None:
        model, found = _from_fov(fov, size, name)
    elif box is not None:
        model, found = _from_box(box, files, name)
    elif second is not None or second_camera is not None:
        if camera is None or second is None or second_camera is None or target is None:
            raise BadInput("calibrate: a pair needs --camera, --second DIR and --second-camera")
        target = _as_seen(target, files)
        model, found = (
            None,
            _pair_of(load_camera(camera, False), load_camera(second_camera, False), files, second, target),
        )
    else:
        assert target is not None
        model, found = _from_board(_as_seen(target, files), files, Freedom(distortion, skew), name)
    if model is not None:
        _write(model, found, out)
    elif out is not None:
        raise BadInput(f"{out}: a pair is no camera; its pose is printed, --json for scripts")
    write_json(found) if as_json else write_text(_readable(found))
    return 0


def _as_seen(board: Board, files: list[str]) -> Board:
    """Of a grid of circles whether it is staggered: as the first picture shows that holds either of them."""
    from rover.vision.calibration.board import find_board

    staggered = replace(board, staggered=True)
    for shot in shots(files) if board.circles else ():
        picture = shot.picture
        if find_board(picture, board) is not None:
            return board
        if find_board(picture, staggered) is not None:
            say("the circles are staggered: --square is taken for the distance between rows")
            return staggered
    return board


def _from_board(board: Board, files: list[str], freedom: Freedom, name: str) -> tuple[CameraModel, dict[str, Any]]:
    from rover.vision.calibration.board import find_board
    from rover.vision.calibration.intrinsics import calibrate

    size, views, given = _views(files, lambda picture: find_board(picture, board), "board")
    result = calibrate(board.points, [view for _, view in views], size, freedom, name)
    if result.coverage < 0.6:
        say(f"the board covers {result.coverage:.0%} of the picture: take more views at its edges and corners")
    return result.camera, _document(result, [file for file, _ in views], given)


def _from_box(text: str, files: list[str], name: str) -> tuple[CameraModel, dict[str, Any]]:
    from rover.vision.calibration.box import calibrate_box, find_box

    width, height = _pair(text, "--box")
    size, views, given = _views(files, find_box, "box")
    result = calibrate_box(width, height, [view for _, view in views], size, name)
    return result.camera, _document(result, [file for file, _ in views], given)


def _from_fov(text: str, size: str | None, name: str) -> tuple[CameraModel, dict[str, Any]]:
    from rover.vision.camera.model import CameraModel

    if size is None:
        raise BadInput("calibrate: --size WIDTHxHEIGHT is needed with --fov")
    across, down = _pair(text, "--fov")
    width, height = _pair(size, "--size", whole=True)
    if not (1.0 <= across < 170.0 and 1.0 <= down < 170.0 and width >= 8 and height >= 8):
        raise BadInput(f"--fov {text} --size {size}: angles of 1 to 170 degrees and 8 pixels or more are expected")
    model = CameraModel.from_fov(name, int(width), int(height), math.radians(across), math.radians(down))
    return model, {"camera": _intrinsics(model)}


def _mounted(camera: str | None, ground: Path) -> tuple[CameraModel, dict[str, Any]]:
    import numpy as np

    from rover.vision.calibration.mount import MOUNT, mount_from_ground, read_points
    from rover.vision.camera.file import load_camera

    if camera is None:
        raise BadInput("calibrate: --camera, with known intrinsics, is needed with --ground")
    table = read_points(ground, ("u", "v", "x", "y"))
    result = mount_from_ground(load_camera(camera, mounted=False), table[:, :2], table[:, 2:])
    sigmas = np.sqrt(np.diag(result.covariance))
    units = [f"{axis}_m" for axis in MOUNT[:3]] + [f"{angle}_deg" for angle in MOUNT[3:]]
    scale = [1.0] * 3 + [180.0 / math.pi] * 3
    values = [getattr(result.camera, entry) for entry in MOUNT]
    return result.camera, {
        "mount": {unit: value * s for unit, value, s in zip(units, values, scale, strict=True)},
        "sigma": {unit: float(value) * s for unit, value, s in zip(units, sigmas, scale, strict=True)},
        "points": len(table),
        "rms_px": result.rms,
        "errors_px": result.errors.tolist(),
    }


def _pair_of(first: CameraModel, other: CameraModel, files: list[str], folder: Path, board: Board) -> dict[str, Any]:
    from rover.capture.picture import files_of
    from rover.cli.pictures import read_picture
    from rover.vision.calibration.board import find_board
    from rover.vision.calibration.pair import ground_homography, pair_from_board

    others = files_of(folder)
    if len(others) != len(files):
        raise BadInput(f"{folder}: {len(others)} pictures for the {len(files)} of the first camera; they go by name")
    views, used = [], []
    for mine, theirs in zip(sorted(files), others, strict=True):
        pictures = read_picture(mine), read_picture(theirs)
        first.check_size(pictures[0].shape, str(mine))
        other.check_size(pictures[1].shape, str(theirs))
        seen = [find_board(picture, board) for picture in pictures]
        if seen[0] is not None and seen[1] is not None:
            views.append((seen[0], seen[1]))
            used.append(mine)
        else:
            say(f"{mine if seen[0] is None else theirs}: no board found")
    pair = pair_from_board(first, other, board.points, views)
    return {
        "rotation": pair.rotation.tolist(),
        "translation_m": pair.translation.tolist(),
        "sigma_translation_m": [math.sqrt(value) for value in pair.covariance.diagonal()[3:]],
        "sigma_rotation_deg": [math.degrees(math.sqrt(value)) for value in pair.covariance.diagonal()[:3]],
        "ground_homography": ground_homography(first, other, pair).tolist() if first.z > 0 else None,
        "rms_px": pair.rms,
        "views": _per_view(used, pair.view_rms),
    }


def _views(
    files: list[str], find: Any, what: str
) -> tuple[tuple[int, int], list[tuple[str, NDArray[np.float64]]], int]:
    """Size of the pictures, those in which the target was found, with its points, and how many there were."""
    from rover.cli.progress import progress

    if not files:
        raise BadInput(f"calibrate: pictures of the {what} are needed")
    size: tuple[int, int] | None = None
    number, found = 0, []
    with progress("pictures") as advance:
        for number, shot in enumerate(shots(files), start=1):
            file, picture = shot.name, shot.picture
            here = (int(picture.shape[1]), int(picture.shape[0]))
            if size is not None and here != size:
                raise BadInput(f"{file}: {here[0]}×{here[1]} pixels, the first picture has {size[0]}×{size[1]}")
            size = here
            points = find(picture)
            if points is None:
                say(f"{file}: no {what} found")
            else:
                found.append((file, points))
            advance(number, max(number, len(files)))
    assert size is not None
    return size, found, number


def _document(result: Calibration, used: list[str], given: int) -> dict[str, Any]:
    return {
        "camera": _intrinsics(result.camera),
        "sigma": result.sigmas,
        "rms_px": result.rms,
        "coverage": result.coverage,
        "pictures": given,
        "views": _per_view(used, result.view_rms, result.tilts),
    }


def _per_view(used: list[str], rms: Any, tilts: Any = None) -> list[dict[str, Any]]:
    rows = [{"image": str(file), "rms_px": float(value)} for file, value in zip(used, rms, strict=True)]
    for row, tilt in zip(rows, tilts if tilts is not None else (), strict=False):
        row["tilt_deg"] = math.degrees(float(tilt))
    return rows


def _intrinsics(camera: CameraModel) -> dict[str, Any]:
    keys = ("name", "width", "height", "fx", "fy", "cx", "cy", "skew")
    return {**{key: getattr(camera, key) for key in keys}, "distortion": list(camera.distortion)}


def _write(camera: CameraModel, found: dict[str, Any], out: Path | None) -> None:
    from rover.vision.calibration.file import camera_toml, write_text_file

    if out is None:
        return
    remark = (
        f"Made by rover calibrate; reprojection {found['rms_px']:.3f} px RMS."
        if "rms_px" in found
        else ("Made by rover calibrate from the field of view.")
    )
    write_text_file(out, camera_toml(replace(camera, name=camera.name or "camera"), [remark]))


def _readable(found: dict[str, Any]) -> str:
    lines = []
    for key, value in found.items():
        if key == "views":
            lines += [f"  {row['rms_px']:.3f} px  " + (f"tilt {row['tilt_deg']:.0f}°  " if "tilt_deg" in row else "")
                      + row["image"] for row in value]  # fmt: skip
        elif isinstance(value, dict):
            lines.append(f"{key}: " + ", ".join(f"{k} {_short(v)}" for k, v in value.items()))
        elif key != "errors_px":
            lines.append(f"{key}: {_short(value)}")
    return "\n".join(lines)


def _short(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_short(entry) for entry in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pair(text: str, option: str, whole: bool = False) -> tuple[float, float]:
    first, _, last = text.lower().replace("×", "x").partition("x")
    try:
        values = (float(first), float(last))
    except ValueError:
        values = (math.nan, math.nan)
    if not all(math.isfinite(v) and v > 0 and (not whole or v == int(v)) for v in values):
        kind = "two whole numbers" if whole else "two positive numbers"
        raise BadInput(f"{option} {text}: {kind} with an x between them are expected")
    return values
