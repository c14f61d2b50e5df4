"""The picture as a level rover would have taken it, from the one that a leaning rover has taken, for flat ground.

What leans shifts the ground in the picture: by 2° and a lens 0.75 m above it, by 4 cm. Everything that comes after,
from the features to the map, lays pictures on the ground by the camera's mount on a level rover; so it is the picture
that is put right, once, and nothing else needs to know.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.capture.frame import Frame
from rover.vision.camera.model import CameraModel

# Leaning less than this, radians, moves no ground by a tenth of a pixel's width.
LEVEL = 0.001


def roll_and_pitch(up: tuple[float, float, float]) -> tuple[float, float]:
    """Of a rover on which the vertical has these components: radians, left side up and nose down."""
    x, y, z = up
    return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


def levelled(frame: Frame, camera: CameraModel, up: tuple[float, float, float]) -> Frame:
    """`up`: the vertical on base_link, any length. What the picture does not hold is marked as not shown."""
    length = math.sqrt(sum(part * part for part in up))
    if length == 0.0 or math.hypot(up[0], up[1]) < LEVEL * length:
        return frame
    pixels = _pixels(camera, up)
    u, v = pixels[..., 0], pixels[..., 1]
    counts = cv2.remap(frame.counts, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = (u >= 0.0) & (v >= 0.0) & (u <= camera.width - 1) & (v <= camera.height - 1)
    return replace(frame, counts=np.asarray(counts, np.uint16), shown=inside)


def _pixels(camera: CameraModel, up: tuple[float, float, float]) -> NDArray[np.float32]:
    """Where each pixel of a level camera is to be taken from, (H, W, 2); what shows no ground stays where it is."""
    ground = camera.ground_lookup.reshape(-1, 2).astype(np.float64)
    roll, pitch = roll_and_pitch(up)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    # Ry(pitch) Rx(roll): base_link to level; points come the other way.
    rotation = np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])
    on_body = np.column_stack((ground, np.zeros(len(ground)))) @ rotation
    e = camera.extrinsic
    optical = on_body @ e[:3, :3].T + e[:3, 3]
    depth = np.where(optical[:, 2] > 1e-6, optical[:, 2], np.nan)
    found = camera.normalized_to_pixel(optical[:, :2] / depth[:, None])
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    own = np.column_stack((u.ravel(), v.ravel())).astype(np.float64)
    pixels = np.where(np.isfinite(found), found, own)
    return pixels.astype(np.float32).reshape(camera.height, camera.width, 2)
