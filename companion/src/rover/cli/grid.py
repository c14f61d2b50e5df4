"""`rover grid`: pictures to a binary occupancy grid (figure 5 of the paper)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.cli.pictures import SOURCE, SOURCE_HELP, check_end, expanded, frames_of, is_source
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.mapping.picture_grid import PictureGrid
    from rover.vision.camera.model import CameraModel

HELP = """Turn pictures of one piece of ground into a binary occupancy grid, for `rover plan --map`.

A cell is occupied where a picture stands out of the ground around: by temperature (16 bits, or a radiometric file),
or by lightness with --visible. No classifier is asked, so a warm mine and a stone look alike. Several pictures must be
taken from the same spot; each adds to what the others say.
Without --camera the pictures were taken from straight above, and each pixel is one cell of --metres-per-pixel. With
--camera the ground in front of the rover is laid out flat, and x is ahead.

\b
Examples:
  rover grid ground.tif --metres-per-pixel 0.01 --out ground.yaml
  rover grid photo.png --visible --out photo.yaml --json
  rover grid clip.mcap?skip=20&count=3 --camera lepton-160 --out ahead.yaml
  rover grid frame1.tif frame2.tif --camera lepton-160 --out ahead.yaml
"""
DEFAULT_METRES_PER_PIXEL = 0.01
# A cell of a grid that is laid out from a mounted camera, metres.
CAMERA_RESOLUTION_M = 0.02


def command(
    pictures: Annotated[list[str], typer.Argument(metavar=f"{SOURCE}…", help=f"All from one spot. {SOURCE_HELP}")],
    out: Annotated[Path, typer.Option("--out", metavar="MAP.yaml", help="The map; its picture is written beside it.")],
    visible: Annotated[bool, typer.Option("--visible", help="By lightness: photographs, colour or grey.")] = False,
    metres_per_pixel: Annotated[
        float | None, typer.Option(metavar="M", help="Size of a pixel on the ground, metres; 0.01 when not given.")
    ] = None,
    camera: Annotated[
        str | None, typer.Option(metavar="CAMERA.toml", help="The mounted camera, a file or a built-in name.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.mapping import map_server

    if metres_per_pixel is not None and camera is not None:
        raise BadInput("--metres-per-pixel and --camera: only one of them can tell the scale")
    if metres_per_pixel is not None and not 1e-4 < metres_per_pixel < 1.0:
        raise BadInput(f"--metres-per-pixel {metres_per_pixel:g}: a value between 0.0001 and 1 is expected")
    if out.suffix not in (".yaml", ".yml"):
        raise BadInput(f"--out {out}: a name that ends in .yaml is expected")
    if camera is not None:
        grid = grid_ahead(pictures, visible, camera)
    else:
        grid = grid_from_above(pictures, visible, metres_per_pixel or DEFAULT_METRES_PER_PIXEL)
    try:
        map_server.save(grid, out)
    except OSError as error:
        raise BadInput(f"--out {out}: cannot be written ({error.strerror})") from error
    found = document(grid, out)
    if as_json:
        write_json(found)
    else:
        write_text(f"{found['occupied']} cells occupied, {found['free']} free, {grid.resolution:g} m a cell: {out}")
    return 0


def grid_from_above(sources: Sequence[str], visible: bool, metres_per_pixel: float) -> PictureGrid:
    """One cell a pixel. Raises BadInput naming the picture that cannot be used."""
    from rover.mapping.picture_grid import PictureGrid

    grid: PictureGrid | None = None
    for file, binary in binaries(sources, visible):
        rows, columns = binary.shape
        grid = grid or PictureGrid(columns * metres_per_pixel, rows * metres_per_pixel, metres_per_pixel)
        try:
            grid.integrate_from_above(binary)
        except BadInput as error:
            raise BadInput(f"{file}: {error}") from error
    assert grid is not None
    return grid


def grid_ahead(sources: Sequence[str], visible: bool, camera: str) -> PictureGrid:
    """The ground that the mounted camera sees, in the axes of base_link. Raises BadInput naming what does not fit."""
    from rover.geometry import Pose2
    from rover.mapping.camera_view import view_polygon
    from rover.mapping.picture_grid import PictureGrid
    from rover.vision.camera.file import load_camera

    model: CameraModel = load_camera(camera)
    outline = view_polygon(model)
    (left, low), (right, high) = outline.min(axis=0).tolist(), outline.max(axis=0).tolist()
    grid = PictureGrid(right - left, high - low, CAMERA_RESOLUTION_M)
    for file, binary in binaries(sources, visible):
        model.check_size(binary.shape, str(file))
        grid.integrate(binary, model, Pose2(-left, -low, 0.0))
    return grid


def binaries(sources: Sequence[str], visible: bool) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Name and `binary_picture` of each picture. Raises BadInput."""
    for source in expanded(sources):
        if not is_source(source):
            yield source, binary_picture(Path(source), visible)
            continue
        check_end(source)
        for frame in frames_of(source):
            name = f"{source}, frame {frame.sequence}"
            yield name, _standing_out(frame.counts.astype("float32") if visible else frame.kelvin(), visible)


def binary_picture(file: Path, visible: bool) -> NDArray[np.bool_]:
    """Where a picture (h, w) stands out of the ground around. Raises BadInput for one that tells nothing."""
    import numpy as np

    from rover.capture.radiometric import read_thermogram
    from rover.cli.pictures import read_picture, say_frame

    if visible:
        grey = read_picture(file)
        if grey.dtype != np.uint8:
            raise BadInput(f"{file}: a 16-bit picture: leave out --visible, or give a photograph of 8 bits")
        return _standing_out(grey.astype(np.float32), visible)
    thermogram = read_thermogram(file)
    say_frame(file, thermogram.frames)
    return _standing_out(thermogram.kelvin, visible)


def _standing_out(values: NDArray[np.float32], visible: bool) -> NDArray[np.bool_]:
    import numpy as np

    from rover.mapping.thermal_anomaly import anomalies
    from rover.mapping.visible_anomaly import visible_anomalies

    if visible:
        return visible_anomalies(values)
    known = np.isfinite(values)
    return anomalies(np.where(known, values, np.float32(np.median(values[known]))))[0]


def document(grid: PictureGrid, out: Path) -> dict[str, Any]:
    """What was written; occupied and free are numbers of cells."""
    rows, columns = grid.shape
    return {
        "occupied": int(grid.occupied.sum()),
        "free": int(grid.free.sum()),
        "width": columns,
        "height": rows,
        "resolution": grid.resolution,
        "out": str(out),
    }
