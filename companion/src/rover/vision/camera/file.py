"""Camera descriptions as a person writes them: TOML, either shipped by name or a file of one's own."""

from __future__ import annotations

import math
from pathlib import Path

from rover.errors import BadInput
from rover.toml_table import Table
from rover.vision.camera.model import CameraModel

BUILT_IN = Path(__file__).resolve().parents[2] / "cameras"

TOP_KEYS = ("name", "width", "height", "intrinsics", "mount")
FOV_KEYS = ("hfov_deg", "vfov_deg")
MATRIX_KEYS = ("fx", "fy", "cx", "cy", "skew", "distortion")
MOUNT_KEYS = ("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg")

# Pixels of a side of a picture.
MIN_SIDE_PX, MAX_SIDE_PX = 8, 8192
# A lens's angle of view, degrees.
MIN_FOV_DEG, MAX_FOV_DEG = 1.0, 169.9
# A focal length over the side of the picture.
MIN_FOCAL, MAX_FOCAL = 0.2, 50.0
MAX_SKEW_PX = 1000.0
MAX_DISTORTION = 1e4
# Of the mount, from the ground between the wheels.
MAX_OFFSET_M = 20.0
MIN_HEIGHT_M = 0.01


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
    top = Table.of_file(camera_file(name_or_path)).only(*TOP_KEYS)
    name = top.text("name")
    width, height = (top.integer(key, MIN_SIDE_PX, MAX_SIDE_PX) for key in ("width", "height"))
    fx, fy, cx, cy, skew, distortion = _lens(top.table("intrinsics").only(*FOV_KEYS, *MATRIX_KEYS), width, height)
    mount = top.table("mount").only(*MOUNT_KEYS)
    x, y = (mount.number(key, -MAX_OFFSET_M, MAX_OFFSET_M, 0.0) for key in ("x_m", "y_m"))
    z = mount.number("z_m", MIN_HEIGHT_M, MAX_OFFSET_M) if mounted or mount.has("z_m") else 0.0
    angles = [math.radians(mount.number(key, -360.0, 360.0, 0.0)) for key in ("roll_deg", "pitch_deg", "yaw_deg")]
    roll, pitch, yaw = angles
    return CameraModel(
        name, width, height, fx, fy, cx, cy, skew, distortion, x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw
    )


def _lens(
    lens: Table, width: int, height: int
) -> tuple[float, float, float, float, float, tuple[float, ...]]:
    """fx, fy, cx, cy, skew in pixels, and the distortion."""
    if lens.has("hfov_deg"):
        for key in ("fx", "fy"):
            if lens.has(key):
                raise lens.error(key, "stands beside hfov_deg: give either the angle or fx and fy, not both")
        hfov = math.radians(lens.number("hfov_deg", MIN_FOV_DEG, MAX_FOV_DEG))
        vfov = math.radians(lens.number("vfov_deg", MIN_FOV_DEG, MAX_FOV_DEG)) if lens.has("vfov_deg") else None
        ideal = CameraModel.from_fov(lens.name, width, height, hfov, vfov)
        fx, fy = ideal.fx, ideal.fy
    else:
        # A focal length far from the picture's size is a slip of unit (millimetres, or the 0.16 of the paper's table).
        fx = lens.number("fx", MIN_FOCAL * width, MAX_FOCAL * width)
        fy = lens.number("fy", MIN_FOCAL * height, MAX_FOCAL * height)
    cx = lens.number("cx", -width, 2.0 * width, (width - 1) / 2.0)
    cy = lens.number("cy", -height, 2.0 * height, (height - 1) / 2.0)
    distortion = lens.numbers("distortion", -MAX_DISTORTION, MAX_DISTORTION, ())
    if len(distortion) not in (0, 4, 5):
        raise lens.error("distortion", "must be [k1, k2, p1, p2] or [k1, k2, p1, p2, k3]")
    return fx, fy, cx, cy, lens.number("skew", -MAX_SKEW_PX, MAX_SKEW_PX, 0.0), distortion
