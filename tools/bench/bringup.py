"""A bring-up on the simulated rig, from the standard file to what the rover really is: what its operator reads."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from rover.bringup.session import Done, bring_up, chosen
from rover.vehicle import load_vehicle
from rover_hil.testing.bench_rig import BenchRig

# How the rover is built, where it is not the standard one.
BUILT = """[wheels]
track_m = 0.213
radius_m = 0.034
right_radius_m = 0.0336
counts_per_revolution = 1400
[battery]
divider_scale = 1.2
[wiring]
left_motor_inverted = true
right_encoder_inverted = true
encoders_swapped = true
sonars = ["right", "left", "centre"]
"""


def main(arguments: list[str]) -> int:
    """Prints the transcript, and what was found beside what is true."""
    parser = argparse.ArgumentParser(prog="python -m tools.bench bringup", description=__doc__)
    parser.add_argument("--seed", type=int, default=1, help="fixes motors, slip and everything else random")
    parser.add_argument("--exact", action="store_true", help="wheels that do not slip, and motors that are alike")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        built, file = folder / "built.toml", folder / "vehicle.toml"
        built.write_text(BUILT, encoding="utf-8")
        rig = BenchRig(built, folder / "memory", options.seed, exact=options.exact)
        try:
            rig.link.connect()
            results = bring_up(rig.link, rig.helper, file, chosen(None, []), on_step=_tell)
        finally:
            rig.close()
        found, true = load_vehicle(file), load_vehicle(built)
    print(f"\n{'':<24}{'found':>12}{'true':>12}{'off':>9}")
    for name, got, wanted in (
        ("left radius, mm", found.wheel_radius * 1e3, true.wheel_radius * 1e3),
        ("right radius, mm", found.right_wheel_radius * 1e3, true.right_wheel_radius * 1e3),
        ("track, mm", found.track_width * 1e3, true.track_width * 1e3),
        ("counts a turn", float(found.counts_per_revolution), float(true.counts_per_revolution)),
        ("divider", found.parameters()["battery_scale"] * 1e-6, true.parameters()["battery_scale"] * 1e-6),
    ):
        print(f"{name:<24}{got:>12.3f}{wanted:>12.3f}{100.0 * (got / wanted - 1.0):>+8.2f}%")
    return 0 if all(done.ok for done in results) else 3


def _tell(done: Done) -> None:
    print(f"{done.name:<9} {'well' if done.ok else 'FAILED'}  {done.message}")
