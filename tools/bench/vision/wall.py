"""Every two pictures of dunr against the wall's plane by survey and adjusted poses.

Beside the bay window and the porch the pictures hold a second plane; a registration that follows that one is right
there and off on the wall, which is what this table shows.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from rover.vision.registration.register import RegistrationSettings, prepare, register_prepared

from tools.bench.vision.facade import marker_transfer
from tools.bench.vision.registration import corner_error
from tools.bench.vision.truth import facade

APART = {"1": (1, 1), "2": (2, 2), "3": (3, 3), "4 to 25": (4, 25)}
MIN_OFF_PX = 10.0


def wall_table(data: Path) -> str:
    """Registered, corner error and marker transfer by distance, both directions, and the pairs that are off."""
    wall, settings = facade(data), RegistrationSettings()
    every = [prepare(picture, settings) for picture in wall.pictures]
    lines = ["| dunr, pictures apart | pairs, both directions | registered | corner error to the wall's plane, px: "
             "median | 90 % | marker transfer, px: median | most |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    off: list[str] = []
    for name, (least, most) in APART.items():
        pairs = [(a, b) for a, b in itertools.permutations(range(len(every)), 2) if least <= abs(a - b) <= most]
        errors, moved = [], []
        for a, b in pairs:
            found = register_prepared(every[a], every[b], settings).homography
            if found is None:
                continue
            errors.append(corner_error(found, wall.across(a, b), wall.pictures[a].shape))
            moved += marker_transfer(wall, a, b, found)
            if errors[-1] > MIN_OFF_PX:
                off.append(f"{a}→{b} {errors[-1]:.0f}")
        lines.append(
            f"| {name} | {len(pairs)} | {len(errors)} | {np.median(errors):.2f} | {np.percentile(errors, 90):.1f} | "
            f"{np.median(moved):.2f} | {max(moved):.1f} |"
        )
    plane = [d for k in range(len(every) - 1) for d in marker_transfer(wall, k, k + 1, wall.across(k, k + 1))]
    lines += [
        "",
        f"Corners off the wall's plane by over {MIN_OFF_PX:g} px: {', '.join(off) or 'none'}.",
        f"The plane itself, by survey and poses, transfers the markers between neighbours with "
        f"{np.median(plane):.1f} px (median; {max(plane):.1f} at most).",
    ]
    return "\n".join(lines)
