"""`rover track`: a folder of frames to camera poses."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.vision.camera.model import CameraModel
    from rover.vision.camera.pose import CameraPose


HELP = """Track a camera through a folder of frames (8 or 16 bits, in the order of their names).

Poses are those of the camera (x right, y down, z forward) in the axes of the first tracked frame. Frames alone don't
tell how large the world is: one unit of length is the distance from the first frame to the plane that it looks at.
With --ground-plane the camera moves over flat ground on its mount ([mount] in the camera file), and poses are in
metres: the map's origin lies on the ground, where base_link was at the first tracked frame, x ahead, z up.
With --map too, poses are in the map of that run, from the second frame on that shows ground which it has seen.
A frame that cannot be placed is left out.

\b
Examples:
  rover track frames --camera camera.toml
  rover track frames --camera camera.toml --json | jq '.poses[-1]'
  rover track frames --camera lepton-160 --ground-plane
  rover track frames --camera lepton-160 --ground-plane --map runs/demo
"""


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of frames.")],
    camera: Annotated[str, typer.Option("--camera", metavar="CAMERA", help="Camera TOML, or a built-in name.")],
    ground_plane: Annotated[
        bool, typer.Option("--ground-plane", help="Flat ground, camera on its mount: metres.")
    ] = False,
    known: Annotated[
        Path | None, typer.Option("--map", metavar="RUN", help="Folder of a run: poses in its map.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.capture.picture import files_of
    from rover.cli.pictures import read_picture
    from rover.cli.progress import progress
    from rover.vision.camera.file import load_camera

    if known is not None and not ground_plane:
        raise BadInput(f"--map {known}: a run's map is one of flat ground: --ground-plane is needed with it")
    model = load_camera(camera, mounted=ground_plane)
    files = files_of(folder)
    pictures = [read_picture(file) for file in files]
    for file, picture in zip(files, pictures, strict=True):
        model.check_size(picture.shape, str(file))
    begin = time.perf_counter()
    with progress("frames") as advance:
        poses = _over_ground(pictures, model, advance, known) if ground_plane else _free(pictures, model, advance)
    each_ms = (time.perf_counter() - begin) * 1e3 / len(files)
    if as_json:
        write_json(document(poses, [file.name for file in files], each_ms))
    else:
        write_text("\n".join(lines(poses, [file.name for file in files], each_ms)))
    return 0


def _free(
    pictures: list[NDArray[Any]], camera: CameraModel, advance: Callable[[int, int], None]
) -> Sequence[CameraPose]:
    from rover.vision.tracking.sequence import SequenceSettings, track_sequence

    return track_sequence(pictures, camera, SequenceSettings(), advance)


def _over_ground(
    pictures: list[NDArray[Any]], camera: CameraModel, advance: Callable[[int, int], None], known: Path | None
) -> Sequence[CameraPose]:
    import numpy as np

    from rover.capture.frame import Frame
    from rover.capture.source import FRAME_PERIOD
    from rover.vision.localization.keyframe_map import load_map
    from rover.vision.tracking.ground_track import track_over_ground

    frames = [
        Frame(picture.astype(np.uint16), index * FRAME_PERIOD, index, kelvin_per_count=None)
        for index, picture in enumerate(pictures)
    ]
    return track_over_ground(frames, camera, advance, None if known is None else load_map(known, camera))


def document(poses: Sequence[CameraPose], names: list[str], each_ms: float) -> dict[str, Any]:
    """The poses as JSON; t in seconds as if a frame came every FRAME_PERIOD: a folder has no times."""
    from rover.capture.source import FRAME_PERIOD

    return {
        "frames": len(names),
        "tracked": len(poses),
        "poses": [
            {"frame": pose.frame, "name": names[pose.frame], "t": round(pose.frame * FRAME_PERIOD, 6)}
            | dict(zip("xyz", map(float, pose.position), strict=True))
            | dict(zip(("qx", "qy", "qz", "qw"), quaternion(pose.rotation), strict=True))
            for pose in poses
        ],
        "time_ms_per_frame": round(each_ms, 3),
    }


def lines(poses: Sequence[CameraPose], names: list[str], each_ms: float) -> list[str]:
    """The poses for a person."""
    head = f"{len(poses)} of {len(names)} frames tracked, {each_ms:.0f} ms a frame"
    return [head] + [
        f"  {names[p.frame]}  " + "  ".join(f"{value:9.5f}" for value in (*p.position, *quaternion(p.rotation)))
        for p in poses
    ]


def quaternion(rotation: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """(x, y, z, w), w ≥ 0, of a rotation matrix (3, 3): the eigenvector of its symmetric form (Bar-Itzhack)."""
    import numpy as np

    (a, b, c), (d, e, f), (g, h, i) = rotation
    form = np.array(
        [
            [a - e - i, 0.0, 0.0, 0.0],
            [d + b, e - a - i, 0.0, 0.0],
            [g + c, h + f, i - a - e, 0.0],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    x, y, z, w = np.linalg.eigh(form, UPLO="L")[1][:, -1]
    sign = -1.0 if w < 0 else 1.0
    return float(sign * x), float(sign * y), float(sign * z), float(sign * w)
