"""`rover track`: a folder of frames to camera poses."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.cli.pictures import DEFAULT_STEPS, SOURCE, SOURCE_HELP, STEPS_HELP, all_shots
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.vision.camera.model import CameraModel
    from rover.vision.camera.pose import CameraPose


HELP = """Track a camera through frames (8 or 16 bits): of a folder, in the order of their names, or of any source.

Poses are those of the camera (x right, y down, z forward) in the axes of the first tracked frame. Frames alone don't
tell how large the world is: one unit of length is the distance from the first frame to the plane that it looks at.
With --ground-plane the camera moves over flat ground on its mount ([mount] in the camera file), and poses are in
metres: the map's origin lies on the ground, where base_link was at the first tracked frame, x ahead, z up.
With --map too, poses are in the map of that run, from the second frame on that shows ground which it has seen.
A frame that cannot be placed is left out.

\b
Examples:
  rover track frames --camera camera.toml
  rover track clip.cptv --camera camera.toml --steps gaussian,stretch
  rover track frames --camera camera.toml --json | jq '.poses[-1]'
  rover track frames --camera lepton-160 --ground-plane
  rover track frames --camera lepton-160 --ground-plane --map runs/demo
"""


def command(
    source: Annotated[str, typer.Argument(metavar=SOURCE, help=SOURCE_HELP)],
    camera: Annotated[str, typer.Option("--camera", metavar="CAMERA", help="Camera TOML, or a built-in name.")],
    ground_plane: Annotated[
        bool, typer.Option("--ground-plane", help="Flat ground, camera on its mount: metres.")
    ] = False,
    known: Annotated[
        Path | None, typer.Option("--map", metavar="RUN", help="Folder of a run: poses in its map.")
    ] = None,
    steps: Annotated[
        str | None, typer.Option(metavar="STEP,…", help=f"{STEPS_HELP[:-1]}; not with --ground-plane.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.cli.progress import progress
    from rover.vision.camera.file import load_camera
    from rover.vision.registration.steps import split_steps

    if known is not None and not ground_plane:
        raise BadInput(f"--map {known}: a run's map is one of flat ground: --ground-plane is needed with it")
    model = load_camera(camera, mounted=ground_plane)
    if steps is not None and ground_plane:
        raise BadInput(f"--steps {steps}: over ground the localizer's own steps run; leave out --ground-plane")
    taken = all_shots([source])
    names, pictures = [Path(shot.name).name for shot in taken], [shot.picture for shot in taken]
    for shot in taken:
        model.check_size(shot.picture.shape, shot.name)
    wanted = split_steps(steps or DEFAULT_STEPS, "--steps")
    begin = time.perf_counter()
    with progress("frames") as advance:
        if ground_plane:
            poses = _over_ground(pictures, model, advance, known)
        else:
            poses = _free(pictures, model, advance, wanted)
    each_ms = (time.perf_counter() - begin) * 1e3 / len(names)
    if as_json:
        write_json(document(poses, names, each_ms))
    else:
        write_text("\n".join(lines(poses, names, each_ms)))
    return 0


def _free(
    pictures: list[NDArray[Any]], camera: CameraModel, advance: Callable[[int, int], None], steps: list[str]
) -> Sequence[CameraPose]:
    from rover.vision.registration.steps import with_steps
    from rover.vision.tracking.sequence import SequenceSettings, track_sequence

    settings = SequenceSettings()
    registration = replace(settings.registration, preprocess=with_steps(settings.registration.preprocess, steps))
    return track_sequence(pictures, camera, replace(settings, registration=registration), advance)


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
