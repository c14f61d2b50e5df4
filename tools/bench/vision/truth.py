"""The real pictures and what is known about them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import read_picture
from rover.vision.camera import CameraModel

Points = NDArray[np.float64]
Picture = NDArray[np.uint8] | NDArray[np.uint16]

WIRIS = CameraModel("wiris", 640, 512, 767.128, 767.128, 312.085, 257.255, 0.0,
                    (-0.0431578, 0.3684112, 9.3220e-05, -0.00063889))  # fmt: skip
"""dunr's camera, from GeoCamCal-TIR.xml."""


@dataclass(frozen=True, eq=False)
class Facade:
    """dunr: pictures in order, each with its surveyed markers (id to pixel) and its pose, camera to world (4, 4)."""

    pictures: list[Picture]
    markers: list[dict[str, tuple[float, float]]]
    poses: list[Points]


def graf(data: Path) -> tuple[list[Picture], list[Points]]:
    """The four pictures and the homographies from the first to the second, third and fourth."""
    folder = data / "graf"
    return (
        [read_picture(folder / f"img{k}.png") for k in (1, 2, 3, 4)],
        [np.loadtxt(folder / f"H1to{k}p") for k in (2, 3, 4)],
    )


def facade(data: Path) -> Facade:
    """dunr with the survey's markers and bundle-adjusted poses."""
    files = sorted((data / "dunr/tiff").iterdir())
    chunk = ElementTree.parse(data / "dunr/ImgCoords-TIR.xml").getroot().find("chunk")
    if chunk is None:
        raise ValueError("dunr/ImgCoords-TIR.xml holds no chunk")
    cameras = {
        str(camera.get("label")).split(".")[0]: camera
        for camera in chunk.iter("camera")
        if camera.find("transform") is not None
    }
    seen: dict[str, dict[str, tuple[float, float]]] = {}
    for marker in chunk.iter("marker"):
        for at in marker.findall("location"):
            pixel = float(at.get("x", "nan")), float(at.get("y", "nan"))
            seen.setdefault(str(at.get("camera_id")), {})[str(marker.get("marker_id"))] = pixel
    chosen = [cameras[file.stem] for file in files]
    return Facade(
        [read_picture(file) for file in files],
        [seen.get(str(camera.get("id")), {}) for camera in chosen],
        [np.array((camera.findtext("transform") or "").split(), float).reshape(4, 4) for camera in chosen],
    )


def landmines(data: Path) -> dict[str, Picture]:
    """Name without ending to picture, in order of name."""
    return {file.stem: read_picture(file) for file in sorted((data / "landmines/images").glob("*.jpg"))}
