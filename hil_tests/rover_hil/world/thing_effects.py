"""What lies about beside rocks, grass and mines, and what mines are like."""

from __future__ import annotations

from collections.abc import Mapping

from rover_hil.world.effect import Effect, Size

THINGS: Mapping[str, Effect] = {
    "litter": Effect(
        "holes, scrap metal and tufts of every height, which are no obstacles but may look like mines",
        "assumed; on real mined ground metal scrap outnumbers mines by hundreds (MacDonald et al., RAND MR-1608, 2003)",
        {
            "holes_per_m2": Size(0.3, 0, 50, "burrows and footprints, 3 to 10 cm wide"),
            "scrap_per_m2": Size(0.3, 0, 50, "2 to 8 cm wide"),
            "scrap_mirrors": Size(0.3, 0, 1, "share of the cold sky in it, at most: bare metal 0.9, rust 0.1"),
            "tufts_per_m2": Size(0.5, 0, 50, "4 to 14 cm wide, cooler, warmer or as warm as the soil"),
            "tuft_m": Size(0.05, 0.01, 0.3, "height, at most"),
        },
    ),
    "mines": Effect(
        "mines of several sizes; buried ones partly laid bare by wind and rain",
        "diameters of common anti-personnel mines, mm: PMA-2 68, Type 72 78, VS-50 90, PMN-2 120",
        {
            "smallest_m": Size(0.034, 0.02, 0.3, "least radius"),
            "largest_m": Size(0.060, 0.02, 0.3, "greatest radius"),
            "exposed": Size(0.1, 0, 1, "share of the buried ones that show a part of their lid"),
        },
    ),
}
