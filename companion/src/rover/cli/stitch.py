"""`rover stitch`: many pictures into one mosaic."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.out_file import spare_inputs
from rover.cli.output import say, write_json, write_text
from rover.cli.pictures import DEFAULT_STEPS, SOURCE, SOURCE_HELP, STEPS_HELP, all_shots
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.vision.mosaic.picture_graph import Placement

HELP = """Stitch pictures of flat ground (or a wall) into one, 16 bits kept.

Pictures that do not hang together with the others are left out and named. With a camera its lens distortion is undone
first.

\b
Examples:
  rover stitch frames/*.tiff --out mosaic.tiff
  rover stitch clip.cptv?count=40 --steps gaussian,stretch --out mosaic.tiff
  rover stitch frames/*.tiff --camera camera.toml --out mosaic.tiff --json
"""


def command(
    images: Annotated[list[str], typer.Argument(metavar=f"{SOURCE}...", help=SOURCE_HELP)],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The mosaic, PNG or TIFF.")],
    camera: Annotated[str | None, typer.Option("--camera", metavar="CAMERA", help="Camera TOML or name.")] = None,
    steps: Annotated[str, typer.Option(metavar="STEP,…", help=STEPS_HELP)] = DEFAULT_STEPS,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.capture.picture import check_name, write_picture
    from rover.cli.progress import progress
    from rover.vision.camera.file import load_camera
    from rover.vision.mosaic.picture_graph import GraphSettings, place_pictures
    from rover.vision.mosaic.stitch import stitch
    from rover.vision.registration.steps import split_steps, with_steps

    settings = GraphSettings()
    preprocess = with_steps(settings.registration.preprocess, split_steps(steps, "--steps"))
    settings = replace(settings, registration=replace(settings.registration, preprocess=preprocess))
    taken = all_shots(images)
    names = [shot.name for shot in taken]
    spare_inputs(out, [Path(place.partition("?")[0].rpartition(":")[2]) for place in (*images, *names)])
    names, pictures = [shot.name for shot in taken], [shot.picture for shot in taken]
    check_name(out, pictures[0].dtype)
    for image, picture in zip(names, pictures, strict=True):
        if picture.dtype != pictures[0].dtype:
            raise BadInput(f"{image}: {picture.dtype} pixels, {names[0]} has {pictures[0].dtype}: give one kind")
    if camera is not None:
        model = load_camera(camera, mounted=False)
        for image, picture in zip(names, pictures, strict=True):
            model.check_size(picture.shape, image)
        pictures = [model.undistort(picture) for picture in pictures]
    with progress("pictures") as advance:
        placement = place_pictures(pictures, settings, advance)
    mosaic, shift = stitch(pictures, placement)
    write_picture(out, mosaic)
    left_out = [name for number, name in enumerate(names) if number not in placement.homographies]
    if left_out:
        say(f"left out, they fit nowhere: {', '.join(left_out)}")
    if as_json:
        write_json(document(placement, shift, names, mosaic.shape, str(out)))
    else:
        placed = len(placement.homographies)
        size = f"{mosaic.shape[1]}×{mosaic.shape[0]}"
        write_text(f"{placed} of {len(names)} pictures placed, RMSE {placement.rmse_px:.2f} px, {size} pixels: {out}")
    return 0


def document(
    placement: Placement, shift: NDArray[np.float64], names: list[str], shape: tuple[int, ...], out: str
) -> dict[str, Any]:
    """What was placed where; homographies lead from each picture's pixels to those of the mosaic."""
    return {
        "placed": len(placement.homographies),
        "rmse_px": placement.rmse_px,
        "width": shape[1],
        "height": shape[0],
        "reference": names[placement.reference],
        "homographies": {
            names[number]: (shift @ homography).tolist()
            for number, homography in sorted(placement.homographies.items())
        },
        "out": out,
    }
