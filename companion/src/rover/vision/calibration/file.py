"""A calibrated camera as the TOML file that every command reads (`rover.vision.camera.file`)."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from rover.errors import BadInput
from rover.vision.camera.model import CameraModel


def camera_toml(camera: CameraModel, remarks: Sequence[str] = ()) -> str:
    """The file's text: `remarks` as comments on top, [mount] only where the camera has a height above the ground."""
    lines = [f"# {remark}" for remark in remarks]
    lines += [f"name = {json.dumps(camera.name)}", f"width = {camera.width}", f"height = {camera.height}", ""]
    lines += ["[intrinsics]"]
    lines += [f"{key} = {_number(getattr(camera, key))}" for key in ("fx", "fy", "cx", "cy")]
    if camera.skew:
        lines.append(f"skew = {_number(camera.skew)}")
    if any(camera.distortion):
        values = (*camera.distortion, 0.0, 0.0, 0.0, 0.0)[: max(4, len(camera.distortion))]
        lines.append(f"distortion = [{', '.join(_number(value) for value in values)}]")
    if camera.z > 0.0:
        lines += ["", "[mount]"]
        lines += [f"{axis}_m = {_number(getattr(camera, axis))}" for axis in ("x", "y", "z")]
        lines += [
            f"{angle}_deg = {_number(math.degrees(getattr(camera, angle)))}" for angle in ("roll", "pitch", "yaw")
        ]
    return "\n".join(lines) + "\n"


def write_text_file(path: Path, text: str) -> None:
    """Writes `text`. Raises BadInput naming the file when that cannot be done."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror})") from error


def _number(value: float) -> str:
    return repr(float(value))
