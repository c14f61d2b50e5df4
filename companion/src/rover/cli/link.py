"""`rover link bench`: the link under load, over a wire as bad as wanted."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import write_json, write_text
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD
from rover.link.rig import RigName, TransportName

if TYPE_CHECKING:
    from rover.link.bench import Bench, BenchResult
    from rover.link.disturbance import Disturbance

HELP = "Measure the link to the firmware."

BENCH_HELP = """Stream motion segments at fifty a second while the wire is disturbed, and count what came of them.

The rover turns on the spot, a few degrees to and fro: give a real one room. Lost and repeated segments are those that
the firmware executed too few or too often, by its own count and by how far its reference has turned. The wire is
disturbed in both directions. A wrong bit costs a CAN frame, as a CAN controller throws such a frame away; nothing
sends it again but the protocol. The clock's error is known on simulated rigs, whose time is the firmware's.

\b
Examples:
  rover link bench --rig sitl
  rover link bench --rig sitl --bit-error-rate 1e-4 --json
  rover link bench --rig sitl --transport can --drop 0.2 --duplicate 0.1 --delay 0.1 --reorder 0.1
  rover link bench --port /dev/ttyACM0 --seconds 20
"""

FIELD = """[mission]
name = "bench"
[area]
width_m = 2.0
height_m = 2.0
[launch]
x_m = 1.0
y_m = 1.0
[field]
rocks = 0
grass = 0
surface_mines = 0
buried_mine_depths_cm = []
"""

app = typer.Typer(help=HELP, no_args_is_help=True, rich_markup_mode=None, add_completion=False)


@app.command("bench", help=BENCH_HELP, short_help="The link under load.")
def bench(
    rig: Annotated[RigName, typer.Option(help="What is at the other end; device needs --port.")] = RigName.SITL,
    transport: Annotated[
        TransportName, typer.Option(help="The wire to a simulated rig; a port's name tells its own.")
    ] = TransportName.SERIAL,
    port: Annotated[str | None, typer.Option(metavar="P", help="A real board, see rover status.")] = None,
    baud: Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")] = DEFAULT_BAUD,
    bit_error_rate: Annotated[float, typer.Option(min=0.0, max=0.01, help="Share of bits that are wrong.")] = 0.0,
    drop: Annotated[float, typer.Option(min=0.0, max=0.9, help="Share of frames that are lost.")] = 0.0,
    duplicate: Annotated[float, typer.Option(min=0.0, max=0.9, help="Share of frames that come twice.")] = 0.0,
    delay: Annotated[float, typer.Option(min=0.0, max=0.9, help="Share of frames that come up to 50 ms late.")] = 0.0,
    reorder: Annotated[float, typer.Option(min=0.0, max=0.9, help="Share of frames that three others pass.")] = 0.0,
    jitter_ms: Annotated[
        float, typer.Option(min=0.0, max=100.0, help="Each frame is late by up to this much, evenly spread.")
    ] = 1.0,
    seconds: Annotated[float, typer.Option(min=1.0, max=3600.0, help="How long, in time of the rig.")] = 60.0,
    seed: Annotated[int, typer.Option(min=0, help="Fixes everything random.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See BENCH_HELP."""
    from rover.link.disturbance import Disturbance

    disturbance = Disturbance(bit_error_rate, drop, duplicate, delay, reorder=reorder, jitter=jitter_ms * 1e-3)
    if rig is RigName.DEVICE and port is None:
        raise BadInput("--rig device: which board? name its port with --port")
    if port is None:
        result = _on_rig(rig.value, transport.value, disturbance, seconds, seed)
    else:
        result = _on_port(port, baud, disturbance, seconds, seed)
    told = {
        "rig": rig.value if port is None else RigName.DEVICE.value,
        "transport": transport.value if port is None else ("can" if port.startswith("can:") else "serial"),
        "seed": seed,
        **result.as_dict(),
    }
    write_json(told) if as_json else write_text(_text(told))
    return 0


def _on_rig(name: str, transport: str, disturbance: Disturbance, seconds: float, seed: int) -> BenchResult:
    """On a simulated rig in an empty field of its own."""
    from rover.link.bench import Bench
    from rover.link.rig import RigOptions, start_rig

    with tempfile.TemporaryDirectory(prefix="rover-bench-", ignore_cleanup_errors=True) as folder:
        mission = Path(folder) / "bench.toml"
        mission.write_text(FIELD, encoding="utf-8")
        process = start_rig(RigOptions(mission, name, seed, transport=transport), Path(folder) / "rig.log")
        try:
            rig = process.connect(DEFAULT_BAUD)
            # Firmware and rig count time from the same moment, so the firmware's clock is known.
            bench = Bench(rig.transport, rig, disturbance, seed, rig.now)
            try:
                return _run(bench, seconds)
            finally:
                rig.close()
        finally:
            process.stop()


def _on_port(port: str, baud: int, disturbance: Disturbance, seconds: float, seed: int) -> BenchResult:
    """On a real board in real time."""
    from rover.link.bench import Bench
    from rover.link.clock import WallClock
    from rover.link.opening import open_frames

    clock = WallClock()
    bench = Bench(open_frames(port, baud, clock), clock, disturbance, seed)
    try:
        return _run(bench, seconds)
    finally:
        bench.close()


def _run(bench: Bench, seconds: float) -> BenchResult:
    from rover.cli.progress import progress

    with progress("seconds") as told:
        return bench.run(seconds, lambda elapsed: told(round(elapsed), round(seconds)))


def _text(told: dict[str, Any]) -> str:
    """The figures for a person."""
    clock = told["clock_error_us"]
    trip = told["round_trip_ms"]
    rows = [
        ("segments sent", f"{told['segments_sent']} in {told['duration_s']:.1f} s"),
        ("transmissions", str(told["transmissions"])),
        ("lost", str(told["segments_lost"])),
        ("repeated", str(told["segments_repeated"])),
        ("bytes per segment", f"{told['bytes_per_segment']:.1f}, with what was sent again "
         f"{told['bytes_per_segment_with_retransmissions']:.1f}"),
        ("round trip", f"{trip['median']:.2f} ms in the median, {trip['p99']:.2f} ms for 99 %"),
        ("clock error", "not known here" if clock is None
         else f"{clock['median']:.0f} µs in the median, {clock['p99']:.0f} µs for 99 %"),
    ]  # fmt: skip
    return "\n".join(f"{name:<18} {value}" for name, value in rows)
