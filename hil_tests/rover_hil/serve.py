"""Sets up a rig for a mission, announces it, serves it, and writes the truth at the end."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

from rover.errors import BadInput
from rover.link.port import SLCAN_BAUD
from rover.mission.config import Mission, load
from rover.mission.outline import inside
from rover.record.tum import write_tum
from rover.vision.camera.file import load_camera

from rover_hil.coverage import judge_coverage
from rover_hil.former_world import drive_on, save_seen
from rover_hil.ground import Ground, build
from rover_hil.parameter_file import settings_of, write_parameter_file
from rover_hil.plant_config import build_plant, describe_camera
from rover_hil.referee import judge_mines, judge_zones
from rover_hil.rig import Rig
from rover_hil.server import Server
from rover_hil.sitl import EmulatorRig, SitlRig

RIGS: dict[str, type[SitlRig]] = {"sitl": SitlRig, "emulator": EmulatorRig}
WIRES = ("serial", "can")


@dataclass(frozen=True)
class Options:
    """What the command line says."""

    mission: Path
    rig: str
    seed: int
    control: Path
    out: Path | None = None
    data: Path | None = None
    linger: float = 60.0
    wire: str = "serial"
    pictures: bool = True
    former: Path | None = None


def check_rig(name: str) -> None:
    """Raises BadInput for a rig that is not known, PreflightFailed for one whose firmware is not built."""
    if name not in RIGS:
        raise BadInput(f"--rig {name}: not known here; there is {', '.join(RIGS)}")
    RIGS[name].command()


def on_wire(mission: Mission, wire: str) -> Mission:
    """The mission with the baud rate of that wire. Raises BadInput for a wire that is not known."""
    if wire not in WIRES:
        raise BadInput(f"--wire {wire}: not known here; there is {', '.join(WIRES)}")
    if wire == "serial":
        return mission
    return replace(mission, rover=replace(mission.rover, baud=SLCAN_BAUD))


def build_rig(
    mission: Mission,
    ground: Ground,
    name: str,
    seed: int,
    wire: str = "serial",
    pictures: bool = True,
    former: Path | None = None,
) -> Rig:
    """The rig of that name in that field; its camera takes `pictures` or none.

    `former`: folder of a run whose rover drives on from where it stands. Raises BadInput, PreflightFailed.
    """
    check_rig(name)
    mission = on_wire(mission, wire)
    model = load_camera(mission.rover.camera)
    plant = build_plant(mission, ground, model, seed, pictures)
    if former is not None:
        drive_on(plant, former, seed)
    settings = settings_of(mission.rover.vehicle)
    if not settings:
        return RIGS[name](plant, describe_camera(model), mission.rover.baud, wire)
    if name != SitlRig.name:
        raise BadInput(f"{mission.rover.vehicle_file}: the board of rig {name} has the standard rover's parameters")
    with tempfile.NamedTemporaryFile(prefix="rover-parameters-") as memory:
        write_parameter_file(SitlRig.command(), Path(memory.name), settings)
        return SitlRig(plant, describe_camera(model), mission.rover.baud, wire, Path(memory.name))


def verdict_of(
    rig: Rig, mission: Mission, ground: Ground, zones: list[dict[str, Any]], detections: list[dict[str, Any]]
) -> dict[str, Any]:
    """What the referee says of the run, ready for JSON."""
    truth = rig.truth()
    area = mission.area.width * mission.area.height
    outline = mission.area.polygon
    mines = [mine for mine in ground.mines if not outline or inside(outline, (mine.x, mine.y))]
    told = [each for each in detections if not outline or inside(outline, (float(each["x"]), float(each["y"])))]
    return {
        "duration_s": rig.now_us / 1e6,
        **rig.verdict(),
        **judge_zones(truth, zones),
        **judge_mines(truth, mines, told, area),
        **judge_coverage(mission, ground, rig.seen()),
    }


def write_truth(out: Path, rig: Rig, ground: Ground, seed: int, verdict: dict[str, Any] | None) -> None:
    """truth.tum (100 Hz), truth.json (what lies where, and the verdict) and the ground that was seen, in `out`."""
    out.mkdir(parents=True, exist_ok=True)
    write_tum(out / "truth.tum", rig.truth())
    document = {"rig": rig.name, "seed": seed, **ground.truth(), "verdict": verdict}
    (out / "truth.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    save_seen(out, rig.seen())


def serve(options: Options) -> None:
    """Runs a rig until its companion is done. Raises RoverError; SIGTERM ends it in order."""
    signal.signal(signal.SIGTERM, _end)
    share_one_core()
    mission = load(options.mission)
    check_rig(options.rig)  # before the field, which takes a while
    ground = build(mission, options.seed, options.data)
    rig = build_rig(mission, ground, options.rig, options.seed, options.wire, options.pictures, options.former)

    def finish(zones: list[dict[str, Any]], detections: list[dict[str, Any]]) -> dict[str, Any]:
        verdict = verdict_of(rig, mission, ground, zones, detections)
        if options.out is not None:
            write_truth(options.out, rig, ground, options.seed, verdict)
        return verdict

    def lost() -> None:
        """A run whose companion died is gone on from where the rover stands now; nobody has asked for a verdict."""
        if options.out is not None and _is_of_this_rig(options.out):
            write_truth(options.out, rig, ground, options.seed, None)

    try:
        server = Server(rig, options.control, finish, lost)
        try:
            announcement = {"port": rig.port, "control": str(options.control)}
            sys.stdout.write(json.dumps(announcement) + "\n")
            sys.stdout.flush()
            server.run(options.linger)
        finally:
            server.close()
    finally:
        rig.close()


def _is_of_this_rig(out: Path) -> bool:
    """False once another run has taken the folder over: its truth is not this rig's."""
    try:
        return bool(json.loads((out / "rig.json").read_text(encoding="utf-8"))["pid"] == os.getpid())
    except (OSError, ValueError, KeyError, TypeError):
        return False


def share_one_core() -> None:
    """Keeps rig and firmware on one core: they take turns 1000 times a simulated second, and waking another core
    each time costs more than the work itself."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[os.getpid() % len(cores)]})


def _end(*_: object) -> NoReturn:
    raise SystemExit(0)
