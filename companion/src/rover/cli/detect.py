"""`rover detect`: candidates in single pictures, and their classes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import say, write_json, write_text
from rover.cli.pictures import SOURCE, SOURCE_HELP, Shot, expanded, shots
from rover.errors import BadInput

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rover.detection.classifier import Classifier
    from rover.vision.camera.model import CameraModel

    Picture = NDArray[np.uint8] | NDArray[np.uint16]

HELP = """Find what may be a mine in thermal pictures.

16 bits are kelvin × 100. Pictures of 8 bits, or of unknown scale, are searched for spots of every size; a scale only
rules out what cannot be a mine. With a camera file the picture is laid on the ground as the rover does it.
Boxes are [x, y, w, h] in pixels of the picture as it lies on disk, whatever its EXIF orientation says. What is a mine
with at least the threshold's probability is a detection, of the likelier kind of mine; --all shows the other candidates
too, as obstacle or background. A picture that cannot be used gets one line on stderr and an `error` in the JSON; the
exit code is then 2.

\b
Examples:
  rover detect drone/*.jpg --json
  rover detect ground.tif --metres-per-pixel 0.01
  rover detect clip.cptv?skip=20&count=5
  rover detect frame.png --camera lepton-160 --threshold 0.5
"""
# By kind; only those that are needed.
Networks = dict[str, "Classifier"]
# Left, top, right and bottom edge, pixels of the picture.
Corners = tuple[float, float, float, float]


def command(
    images: Annotated[list[str], typer.Argument(metavar=f"{SOURCE}…", help=SOURCE_HELP)],
    metres_per_pixel: Annotated[
        float | None, typer.Option(metavar="M", help="Size of a pixel on the ground, metres.")
    ] = None,
    camera: Annotated[
        str | None, typer.Option(metavar="CAMERA.toml", help="The radiometric camera, a file or a built-in name.")
    ] = None,
    threshold: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            max=1.0,
            metavar="T",
            help="The least probability of a mine. Without it the network's own.",
        ),
    ] = None,
    show_all: Annotated[bool, typer.Option("--all", help="Show also the candidates below the threshold.")] = False,
    model: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Another ONNX model than the one that ships.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.vision.camera.file import load_camera

    if metres_per_pixel is not None and camera is not None:
        raise BadInput("--metres-per-pixel and --camera: only one of them can tell the scale")
    if metres_per_pixel is not None and not 1e-4 < metres_per_pixel < 1.0:
        raise BadInput(f"--metres-per-pixel {metres_per_pixel:g}: a value between 0.0001 and 1 is expected")
    mount = load_camera(camera) if camera is not None else None
    networks = load_networks(model, metres_per_pixel is not None, mount is not None)
    entries, faults = [], []
    images = expanded(images)
    for image in images:
        try:
            for shot in shots([image]):
                entries.append(examine(shot, metres_per_pixel, threshold, networks, mount, show_all))
        except BadInput as error:
            faults.append(error)
            entries.append({"image": image, "error": str(error), "time_ms": None, "detections": []})
    if len(images) == 1 and faults:
        raise faults[0]
    for fault in faults:
        say(str(fault))
    if as_json:
        write_json(entries)
    else:
        write_text("\n".join(text(entry) for entry in entries))
    return BadInput.exit_code if faults else 0


def examine(
    shot: Shot,
    metres_per_pixel: float | None,
    threshold: float | None,
    networks: Networks,
    camera: CameraModel | None = None,
    show_all: bool = False,
) -> dict[str, Any]:
    """One picture's entry of the JSON. `time_ms` is detection alone, the picture already read. Raises BadInput."""
    import numpy as np

    from rover.detection.classifier import GROUND, PICTURES
    from rover.detection.ground import detect  # noqa: F401  fetched before the clock runs
    from rover.detection.ground.image import rectifier_of
    from rover.detection.picture import detect as picture_detect
    from rover.detection.picture.check import check_picture

    picture = shot.picture
    size = (camera.width, camera.height) if camera is not None else None
    check_picture(picture, shot.name, size, camera is not None)
    if camera is not None:
        rectifier_of(camera)  # its tables are made once for all pictures
    scaled = metres_per_pixel is not None and picture.dtype == np.uint16
    network = networks[GROUND if camera is not None or scaled else PICTURES]
    if network.kind == PICTURES:
        picture_detect.prepare(network)
    begin = time.perf_counter()
    if camera is not None:
        found = in_view(picture, camera, network)
    elif metres_per_pixel is not None and scaled:
        found = in_kelvin(picture, metres_per_pixel, network)
    else:
        found = in_grey(picture, metres_per_pixel, network)
    time_ms = (time.perf_counter() - begin) * 1e3
    least = network.threshold if threshold is None else threshold
    size = (picture.shape[1], picture.shape[0])
    detections = [detection(cut(corners, size), p, least) for corners, p in found]
    return {
        "image": shot.name,
        "time_ms": round(time_ms, 3),
        "detections": [each for each in detections if show_all or is_mine(each["p"], least)],
    }


def is_mine(p: dict[str, float], threshold: float) -> bool:
    """Whether both kinds of mine together reach the threshold."""
    from rover.detection.classifier import MINES

    return sum(p[name] for name in MINES) >= threshold


def detection(bbox: list[float], p: dict[str, float], threshold: float) -> dict[str, Any]:
    """One candidate of the JSON: at the threshold of the likelier kind of mine, below it of the likeliest other class,
    whichever class is the most probable of all."""
    from rover.detection.classifier import MINES

    told = {name: round(value, 6) for name, value in p.items()}
    names = [name for name in told if (name in MINES) == is_mine(told, threshold)]
    return {"bbox": bbox, "class": max(names, key=lambda name: (told[name], name)), "p": told}


def load_networks(model: Path | None, scaled: bool, mounted: bool) -> Networks:
    """Those that pictures may need: a mounted camera tells kelvin and metres, a scale does so for 16 bits alone.

    model: a file to take in place of the one that ships, for the kind that it says it is. Raises BadInput.
    """
    from rover.detection.classifier import GROUND, PICTURES, Classifier, default_model

    kinds = (GROUND,) if mounted else (PICTURES, GROUND) if scaled else (PICTURES,)
    given = [] if model is None else [Classifier(model, kinds[0] if len(kinds) == 1 else None)]
    networks = {classifier.kind: classifier for classifier in given}
    return {kind: networks.get(kind) or Classifier(default_model(kind), kind) for kind in kinds}


def in_grey(
    picture: Picture, metres_per_pixel: float | None, classifier: Classifier
) -> list[tuple[Corners, dict[str, float]]]:
    """Detections of a picture without kelvin, or without a scale."""
    import numpy as np

    from rover.detection.picture.detect import detect_in_picture

    values = picture.astype(np.float32)
    if picture.dtype == np.uint16:
        low, high = np.percentile(values[::2, ::2], (0.5, 99.5))
        values = np.clip((values - np.float32(low)) * np.float32(255.0 / max(high - low, 1.0)), 0.0, 255.0)
    return [
        ((d.x - d.extent / 2, d.y - d.extent / 2, d.x + d.extent / 2, d.y + d.extent / 2), d.p)
        for d in detect_in_picture(values, classifier, metres_per_pixel)
    ]


def in_kelvin(
    picture: Picture, metres_per_pixel: float, classifier: Classifier
) -> list[tuple[Corners, dict[str, float]]]:
    """Detections of a radiometric picture taken from straight above."""
    import numpy as np

    from rover.capture.frame import Frame
    from rover.detection.ground.detect import DetectSettings, detect
    from rover.detection.ground.image import from_picture

    ground = from_picture(Frame(picture.astype(np.uint16), 0.0, 0).kelvin(), metres_per_pixel)
    across, down = picture.shape[1] / ground.kelvin.shape[1], picture.shape[0] / ground.kelvin.shape[0]
    found = []
    for detection in detect(ground, classifier, DetectSettings()):
        row, column, height, width = detection.bbox
        found.append(((column * across, row * down, (column + width) * across, (row + height) * down), detection.p))
    return found


def in_view(picture: Picture, camera: CameraModel, classifier: Classifier) -> list[tuple[Corners, dict[str, float]]]:
    """Detections of a frame of a mounted camera: found on the ground plane, told in the frame's own pixels."""
    import numpy as np

    from rover.capture.frame import Frame
    from rover.detection.ground.detect import DetectSettings, detect
    from rover.detection.ground.image import rectifier_of

    ground = rectifier_of(camera).rectify(Frame(picture.astype(np.uint16), 0.0, 0))
    found = []
    for detection in detect(ground, classifier, DetectSettings()):
        row, column, height, width = detection.bbox
        corners = np.array([(row + a * height, column + b * width) for a in (0, 1) for b in (0, 1)], float)
        pixels = camera.ground_to_pixel(ground.to_base(corners))
        if np.isfinite(pixels).all():
            (left, top), (right, bottom) = pixels.min(axis=0).tolist(), pixels.max(axis=0).tolist()
            found.append(((left, top, right, bottom), detection.p))
    return found


def cut(corners: Corners, size: tuple[int, int]) -> list[float]:
    """[x, y, w, h], cut off at the border of a picture of this size (width, height)."""
    left, right = (min(max(edge, 0.0), float(size[0])) for edge in (corners[0], corners[2]))
    top, bottom = (min(max(edge, 0.0), float(size[1])) for edge in (corners[1], corners[3]))
    return [round(value, 2) for value in (left, top, right - left, bottom - top)]


def text(entry: dict[str, Any]) -> str:
    """One picture's entry for a person."""
    if "error" in entry:
        return f"{entry['image']}: not searched"
    lines = [f"{entry['image']}: {len(entry['detections'])} found, {entry['time_ms']:.1f} ms"]
    for found in entry["detections"]:
        x, y, w, h = found["bbox"]
        lines.append(f"  {found['class']:<11} p {found['p'][found['class']]:.2f}  x {x:g} y {y:g} w {w:g} h {h:g}")
    return "\n".join(lines)
