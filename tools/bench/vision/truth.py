"""The real pictures and what is known about them."""

from __future__ import annotations

import csv
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rover.capture.picture import read_picture
from rover.vision.camera.model import CameraModel

Points = NDArray[np.float64]
Picture = NDArray[np.uint8] | NDArray[np.uint16]

# dunr's camera, from GeoCamCal-TIR.xml.
WIRIS = CameraModel("wiris", 640, 512, 767.128, 767.128, 312.085, 257.255, 0.0,
                    (-0.0431578, 0.3684112, 9.3220e-05, -0.00063889))  # fmt: skip

# The camera that belongs to dunr's poses (ImgCoords-TIR.xml): they were adjusted without a lens's distortion.
ADJUSTED = np.array([[773.73270872853072, 0.0, 320.0], [0.0, 773.73270872853072, 256.0], [0.0, 0.0, 1.0]])

AXES = ("Easting (X)(m)", "Northing (Y)(m)", "Height (Z)(m)")


@dataclass(frozen=True, eq=False)
class Facade:
    """dunr: pictures in order, each with its surveyed markers (id to pixel) and its pose, camera to world (4, 4).

    survey: where the markers lie on the wall (id to metres on the plane through all of them).
    plane: that plane, in the world of the poses: (n, d) with n·X = d.
    """

    pictures: list[Picture]
    markers: list[dict[str, tuple[float, float]]]
    poses: list[Points]
    survey: dict[str, Points]
    plane: tuple[Points, float]

    def across(self, a: int, b: int) -> Points:
        """The homography (3, 3) of the wall's plane from picture a to picture b, by survey and poses alone."""
        (normal, offset), (pose_a, pose_b) = self.plane, (np.linalg.inv(self.poses[k]) for k in (a, b))
        turn = pose_b[:3, :3] @ pose_a[:3, :3].T
        shift = pose_b[:3, 3] - turn @ pose_a[:3, 3]
        facing = pose_a[:3, :3] @ normal
        distance = offset + facing @ pose_a[:3, 3]
        homography = ADJUSTED @ (turn + np.outer(shift, facing) / distance) @ np.linalg.inv(ADJUSTED)
        return np.asarray(homography / homography[2, 2])


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
    surveyed = _surveyed(data / "dunr/GeomControl.csv", chunk)
    return Facade(
        [read_picture(file) for file in files],
        [seen.get(str(camera.get("id")), {}) for camera in chosen],
        [np.array((camera.findtext("transform") or "").split(), float).reshape(4, 4) for camera in chosen],
        *_on_the_wall(surveyed, chunk),
    )


def _surveyed(control: Path, chunk: ElementTree.Element) -> dict[str, Points]:
    """Markers' ids to where the survey puts them (3,), metres."""
    with control.open(encoding="utf-8-sig", newline="") as file:
        space = {row["Point ID"]: np.array([float(row[name]) for name in AXES]) for row in csv.DictReader(file)}
    named = {str(m.get("id")): str(m.get("label")) for m in chunk.iter("marker") if m.get("label") in space}
    return {marker: space[named[marker]] for marker in sorted(named)}


def _on_the_wall(
    surveyed: dict[str, Points], chunk: ElementTree.Element
) -> tuple[dict[str, Points], tuple[Points, float]]:
    """Markers' ids to their places (2,) in the plane that fits the survey best, and that plane in the poses' world."""
    places = np.array(list(surveyed.values()))
    centre = places.mean(axis=0)
    axes = np.linalg.svd(places - centre)[2]
    found = chunk.find(".//component/transform")
    if found is None:
        raise ValueError("dunr/ImgCoords-TIR.xml does not say where its poses lie in the survey")
    turn = np.array((found.findtext("rotation") or "").split(), float).reshape(3, 3)
    origin = np.array((found.findtext("translation") or "").split(), float)
    scale = float(found.findtext("scale") or "nan")
    plane = axes[2] @ turn, float(axes[2] @ (centre - origin)) / scale
    return dict(zip(surveyed, (places - centre) @ axes[:2].T, strict=True)), plane


def landmines(data: Path) -> dict[str, Picture]:
    """Name without ending to picture, in order of name."""
    return {file.stem: read_picture(file) for file in sorted((data / "landmines/images").glob("*.jpg"))}
