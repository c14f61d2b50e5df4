"""Camera descriptions as a person writes them: TOML, either shipped by name or a file of one's own."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rover.errors import BadInput
from rover.toml_file import read_toml
from rover.vision.camera.model import CameraModel

BUILT_IN = Path(__file__).resolve().parents[2] / "cameras"

TOP_KEYS = ("name", "width", "height", "intrinsics", "mount")
FOV_KEYS = ("hfov_deg", "vfov_deg")
MATRIX_KEYS = ("fx", "fy", "cx", "cy", "skew", "distortion")
MOUNT_KEYS = ("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg")


def built_in_cameras() -> list[str]:
    """Names of the cameras that ship with the project."""
    return sorted(file.stem for file in BUILT_IN.glob("*.toml"))


def camera_file(name_or_path: str | Path) -> Path:
    """The TOML file of a built-in camera's name, or the path itself. Raises BadInput when there is none."""
    text = str(name_or_path)
    file = BUILT_IN / f"{text}.toml" if text in built_in_cameras() else Path(text)
    if not file.is_file():
        raise BadInput(f"{text}: neither a camera file nor a built-in camera ({', '.join(built_in_cameras())})")
    return file


def load_camera(name_or_path: str | Path, mounted: bool = True) -> CameraModel:
    """The camera of that built-in name, or of that TOML file.

    mounted: where it sits on the rover must be given; without, [mount] may be left out.

    Raises BadInput (one line: file, key, what is expected) for anything that does not describe a camera.
    """
    file = camera_file(name_or_path)
    return _camera(read_toml(file), str(file), mounted)


def _camera(content: dict[str, Any], where: str, mounted: bool) -> CameraModel:
    _only(content, TOP_KEYS, where)
    name = content.get("name")
    if not isinstance(name, str) or not name:
        raise BadInput(f"{where}: name: a text is expected")
    width, height = (_size(content, key, where) for key in ("width", "height"))
    mount = _table(content, "mount", MOUNT_KEYS, where) if mounted or "mount" in content else {}
    values = {key: _number(mount, key, f"{where}: mount", 0.0) for key in MOUNT_KEYS}
    if mounted and values["z_m"] <= 0.0:
        raise BadInput(f"{where}: mount.z_m: a height above the ground is expected, got {values['z_m']}")
    placed = {
        "x": values["x_m"],
        "y": values["y_m"],
        "z": values["z_m"],
        "roll": math.radians(values["roll_deg"]),
        "pitch": math.radians(values["pitch_deg"]),
        "yaw": math.radians(values["yaw_deg"]),
    }
    lens = _table(content, "intrinsics", FOV_KEYS + MATRIX_KEYS, where)
    skew = _number(lens, "skew", f"{where}: intrinsics", 0.0)
    distortion = _distortion(lens, where)
    if "hfov_deg" in lens:
        if "fx" in lens or "fy" in lens:
            raise BadInput(f"{where}: intrinsics: give either hfov_deg or fx and fy, not both")
        hfov = _fov(lens, "hfov_deg", where)
        vfov = _fov(lens, "vfov_deg", where) if "vfov_deg" in lens else None
        ideal = CameraModel.from_fov(name, width, height, hfov, vfov)
        fx, fy = ideal.fx, ideal.fy
    else:
        fx = _number(lens, "fx", f"{where}: intrinsics", None)
        fy = _number(lens, "fy", f"{where}: intrinsics", None)
    # A focal length far from the picture's size is a slip of unit (millimetres, or the 0.16 of the paper's table).
    if not (0.2 * width < fx < 50.0 * width and 0.2 * height < fy < 50.0 * height):
        raise BadInput(f"{where}: intrinsics: focal length in pixels expected, got fx = {fx:g}, fy = {fy:g}")
    cx = _number(lens, "cx", f"{where}: intrinsics", (width - 1) / 2.0)
    cy = _number(lens, "cy", f"{where}: intrinsics", (height - 1) / 2.0)
    return CameraModel(name, width, height, fx, fy, cx, cy, skew, distortion, **placed)


def _only(table: dict[str, Any], keys: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in keys:
            raise BadInput(f"{where}: unknown key '{key}'; known: {', '.join(keys)}")


def _table(content: dict[str, Any], key: str, keys: tuple[str, ...], where: str) -> dict[str, Any]:
    table = content.get(key)
    if not isinstance(table, dict):
        raise BadInput(f"{where}: a table [{key}] is expected")
    _only(table, keys, f"{where}: [{key}]")
    return table


def _number(table: dict[str, Any], key: str, where: str, default: float | None) -> float:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise BadInput(f"{where}.{key}: a number is expected" + ("" if key in table else ", it is missing"))
    return float(value)


def _size(content: dict[str, Any], key: str, where: str) -> int:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 8 <= value <= 8192:
        raise BadInput(f"{where}: {key}: a number of pixels between 8 and 8192 is expected, got {value!r}")
    return value


def _fov(lens: dict[str, Any], key: str, where: str) -> float:
    degrees = _number(lens, key, f"{where}: intrinsics", None)
    if not 1.0 <= degrees < 170.0:
        raise BadInput(f"{where}: intrinsics.{key}: an angle of 1 to 170 degrees is expected, got {degrees:g}")
    return math.radians(degrees)


def _distortion(lens: dict[str, Any], where: str) -> tuple[float, ...]:
    values = lens.get("distortion", [])
    numbers = isinstance(values, list) and all(isinstance(v, int | float) and math.isfinite(v) for v in values)
    if not numbers or len(values) not in (0, 4, 5):
        raise BadInput(f"{where}: intrinsics.distortion: [k1, k2, p1, p2] or [k1, k2, p1, p2, k3] is expected")
    return tuple(float(v) for v in values)
