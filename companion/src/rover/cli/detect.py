"""`rover detect`: candidates in pictures taken from straight above, and their classes."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from rover.cli.output import write_json, write_text
from rover.errors import BadInput

if TYPE_CHECKING:
    from rover.detection.classifier import Classifier
    from rover.detection.detect import Detection

HELP = """Find what may be a mine in thermal pictures taken from straight above.

Boxes are [x, y, w, h] in pixels of the picture as it lies on disk. The class is the most probable one; `background`
is a candidate that the classifier takes for soil.

\b
Examples:
  rover detect ground.tif --metres-per-pixel 0.01
  rover detect frames/*.png --metres-per-pixel 0.004 --threshold 0.5 --json
"""
TEXTURE_KELVIN = 0.6
"""Standard deviation of bare ground that pictures without a scale are brought to, as the classifier's training did."""


def command(
    images: Annotated[list[Path], typer.Argument(metavar="IMAGES…", help="Pictures, 8 or 16 bits.")],
    metres_per_pixel: Annotated[float, typer.Option(metavar="M", help="Size of a pixel on the ground, metres.")],
    threshold: Annotated[
        float,
        typer.Option(min=0.0, max=1.0, metavar="T", help="Leave out what is a mine with less probability than this."),
    ] = 0.0,
    model: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Another ONNX model than the one that ships.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.detection.classifier import Classifier, default_model

    if not 1e-4 < metres_per_pixel < 1.0:
        raise BadInput(f"--metres-per-pixel {metres_per_pixel:g}: a value between 0.0001 and 1 is expected")
    classifier = Classifier(model or default_model())
    entries = [examine(image, metres_per_pixel, threshold, classifier) for image in images]
    if as_json:
        write_json(entries)
    else:
        write_text("\n".join(text(entry) for entry in entries))
    return 0


def examine(file: Path, metres_per_pixel: float, threshold: float, classifier: Classifier) -> dict[str, Any]:
    """One picture's entry of the JSON. `time_ms` is detection alone, the picture already read. Raises BadInput."""
    from rover.capture.picture import read_picture
    from rover.detection.classifier import MINES
    from rover.detection.detect import DetectSettings, detect
    from rover.detection.ground_image import from_picture

    picture = read_picture(file)
    values = temperatures(picture)
    begin = time.perf_counter()
    ground = from_picture(values, metres_per_pixel)
    found = detect(ground, classifier, DetectSettings())
    time_ms = (time.perf_counter() - begin) * 1e3
    scale = (picture.shape[1] / ground.kelvin.shape[1], picture.shape[0] / ground.kelvin.shape[0])
    return {
        "image": str(file),
        "time_ms": round(time_ms, 3),
        "detections": [
            {
                "bbox": box_on_disk(detection, scale, (picture.shape[1], picture.shape[0])),
                "class": detection.label,
                "p": {name: round(p, 6) for name, p in detection.p.items()},
            }
            for detection in found
            if sum(detection.p[name] for name in MINES) >= threshold
        ],
    }


def temperatures(picture: NDArray[np.uint8] | NDArray[np.uint16]) -> NDArray[np.float32]:
    """A picture (h, w) as kelvin: 16 bits are kelvin × 100; 8 bits tell no scale, so the ground's texture sets it."""
    if picture.dtype == np.uint16:
        return picture.astype(np.float32) / np.float32(100.0)
    values = picture.astype(np.float32)
    spread = 1.4826 * float(np.median(np.abs(values - np.median(values))))
    return values * np.float32(TEXTURE_KELVIN / max(spread, 1.0))


def box_on_disk(detection: Detection, scale: tuple[float, float], size: tuple[int, int]) -> list[float]:
    """[x, y, w, h] in the picture's own pixels, cut off at its border; `scale`: its pixels per ground pixel (x, y)."""
    row, column, height, width = detection.bbox
    left, right = (min(max(edge * scale[0], 0.0), size[0]) for edge in (column, column + width))
    top, bottom = (min(max(edge * scale[1], 0.0), size[1]) for edge in (row, row + height))
    return [round(value, 2) for value in (left, top, right - left, bottom - top)]


def text(entry: dict[str, Any]) -> str:
    """One picture's entry for a person."""
    lines = [f"{entry['image']}: {len(entry['detections'])} found, {entry['time_ms']:.1f} ms"]
    for found in entry["detections"]:
        x, y, w, h = found["bbox"]
        lines.append(f"  {found['class']:<11} p {found['p'][found['class']]:.2f}  x {x:g} y {y:g} w {w:g} h {h:g}")
    return "\n".join(lines)
