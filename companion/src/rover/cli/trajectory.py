"""`rover trajectory`: a path to the constant-jerk segments that the firmware drives."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput
from rover.plain_file import plain_file
from rover.vehicle import STANDARD

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rover.motion.path.piece import Stretch
    from rover.motion.segment import Segment
    from rover.motion.trajectory.checked import CheckedTrajectory

HELP = """Turn a path into constant-jerk segments.

PATH is what `rover plan --json` prints, {"path": [[x, y], ...]} or a bare list of points, metres; - reads it from
stdin. Corners are rounded by at most --tolerance; with --map as far as the map has room for the robot, and by at most
--tolerance if that is given too. Corners without room are turned on the spot. The segments are checked as they are
sent: limits, distance from the path, and with --map the swept footprint.

\b
Examples:
  rover trajectory path.json
  rover trajectory path.json --tolerance 0.1 --cruise 0.2 --lateral 0.2 --json
  rover trajectory path.json --plot trajectory.svg
  rover trajectory path.json --map field.toml --robot-radius 0.15 --segments segments.csv
  rover plan --map field.toml --start 2,0.5 --goal 2,2.5 --json | rover trajectory - --map field.toml
"""

# Most that a corner is cut by without a map.
TOLERANCE_M = 0.05
# Most that a corner is cut by with a map, which bounds it further; beyond this nothing is gained.
MAX_CUT_WITH_MAP_M = 0.3


# With a map: most that a corner is moved outward by, to make room for its curve.
MAX_WIDEN_M = 0.06


def command(
    path: Annotated[str, typer.Argument(metavar="PATH", help="A JSON file, or - for stdin.")],
    cruise: Annotated[float | None, typer.Option(metavar="V", help="Most speed, m/s; the vehicle's own.")] = None,
    lateral: Annotated[float, typer.Option(metavar="A", help="Most lateral acceleration, m/s².")] = 0.25,
    tolerance: Annotated[
        float | None, typer.Option(metavar="M", help="Most that a corner may be cut by, metres; 0.05 without a map.")
    ] = None,
    map_file: Annotated[Path | None, typer.Option("--map", metavar="FILE", help="Map: .toml, .yaml or .map.")] = None,
    robot_radius: Annotated[float, typer.Option(metavar="R", help="Radius of the robot, metres.")] = STANDARD.radius,
    resolution: Annotated[float, typer.Option(metavar="M", help="Metres per cell of a .map file.")] = 1.0,
    unknown: Annotated[
        Literal["blocked", "free"], typer.Option(help="Ground of which a .yaml map says nothing.")
    ] = "blocked",
    heading: Annotated[
        float | None, typer.Option(metavar="RAD", help="Where the rover faces at first; along the path otherwise.")
    ] = None,
    segments: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the segments as CSV.")] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Plot path, speed, acceleration and turn rate: .svg or .png.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.motion.path.clearance import ClearanceMap
    from rover.motion.path.limits import DrivingLimits
    from rover.motion.path.rounding import BlendSettings
    from rover.motion.profile import MotionError
    from rover.motion.trajectory.checked import plan_checked
    from rover.planning.fields import load_field

    most = STANDARD.travel.speed
    _within("--cruise", cruise, 0.01, most, f"m/s; the vehicle's limit is {most:g}")
    _within("--lateral", lateral, 0.001, 10.0, "m/s²")
    _within("--tolerance", tolerance, 0.0, 10.0, "metres")
    _within("--robot-radius", robot_radius, 0.0, 1000.0, "metres")
    _within("--heading", heading, -1000.0, 1000.0, "radians")
    if plot is not None and plot.suffix.lower() not in (".svg", ".png"):
        raise BadInput(f"--plot {plot}: the name must end in .svg or .png")
    points = read_path(path)
    clearance = ClearanceMap.of(load_field(map_file, resolution, unknown, say), robot_radius) if map_file else None
    if tolerance is None:
        tolerance = TOLERANCE_M if clearance is None else MAX_CUT_WITH_MAP_M
    limits = DrivingLimits.of(STANDARD, cruise, lateral)
    settings = BlendSettings(max_cut=tolerance, widen=min(MAX_WIDEN_M, tolerance / 3.0))
    checked = plan_checked(points, limits, settings, clearance, heading)
    if checked.trajectory.failure:
        raise MotionError(checked.trajectory.failure)
    if segments is not None:
        write_segments(segments, checked.trajectory.segments)
    if plot is not None:
        write_plot(plot, checked, points)
    result = document(checked, points)
    if as_json:
        write_json(result)
    else:
        write_text(text(result))
    return 0


def _within(option: str, value: float | None, low: float, high: float, unit: str) -> None:
    if value is not None and not low <= value <= high:
        raise BadInput(f"{option} {value:g}: must be from {low:g} to {high:g} {unit}")


def read_path(name: str) -> list[list[float]]:
    """The points of a path file. Raises BadInput."""
    where = "stdin" if name == "-" else name
    try:
        content = sys.stdin.read() if name == "-" else plain_file(Path(name)).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a text file"
        raise BadInput(f"{where}: {reason}") from error
    try:
        data = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{where}: not valid JSON: {error}") from error
    points = data.get("path") if isinstance(data, dict) else data
    if not isinstance(points, list):
        raise BadInput(f'{where}: needs a list of points [x, y], or {{"path": [[x, y], ...]}}')
    for number, point in enumerate(points, start=1):
        if not (isinstance(point, list) and len(point) == 2 and all(_is_finite(value) for value in point)):
            raise BadInput(f"{where}: point {number} must be [x, y] with finite numbers, not {json.dumps(point)[:60]}")
    if len(points) < 2:
        raise BadInput(f"{where}: a path needs at least two points, not {len(points)}")
    return [[float(x), float(y)] for x, y in points]


def _is_finite(value: Any) -> bool:
    # Larger than any map: the squares of such numbers would not be finite either.
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e7 and math.isfinite(value)


def serial_bytes(segments: Sequence[Segment]) -> int:
    """Bytes on the serial line, framing included, without repetitions."""
    from rover_protocol import framing, messages

    total = 0
    for index, segment in enumerate(segments):
        number = index & 0xFFFF
        fields: list[tuple[str, dict[str, int]]] = [
            (
                "SegmentTravel",
                {"index": number, "duration": segment.duration_us, "jerk_travel": segment.jerk_travel},
            ),
            ("SegmentHeading", {"index": number, "jerk_heading": segment.jerk_heading, "flags": segment.flags}),
        ]
        if segment.begin:
            fields.insert(0, ("SegmentStart", {"index": number, "start_time": 0}))
        for name, values in fields:
            message = messages.BY_NAME[name]
            total += len(framing.encode(message.ID, number & 0xFF, message.pack(**values)))
    return total


def write_segments(path: Path, segments: Sequence[Segment]) -> None:
    """One segment a line, the integers of the wire. Raises BadInput."""
    lines = ["duration_us,jerk_travel_um_s3,jerk_heading_urad_s3,flags"]
    lines += [f"{s.duration_us},{s.jerk_travel},{s.jerk_heading},{s.flags}" for s in segments]
    try:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path}: can't be written: {error.strerror or error}") from error


def write_plot(path: Path, checked: CheckedTrajectory, points: list[list[float]]) -> None:
    """The trajectory as SVG or PNG. Raises BadInput when there is nothing to draw or the file can't be written."""
    from rover.motion.trajectory.plot import draw

    if not checked.trajectory.segments:
        raise BadInput(f"--plot {path}: the path leads nowhere, there is nothing to draw")
    page = draw(checked.trajectory, checked.driven, points)
    try:
        path.write_bytes(page.png() if path.suffix.lower() == ".png" else page.svg().encode())
    except OSError as error:
        raise BadInput(f"--plot {path}: can't be written: {error.strerror or error}") from error
    say(f"plotted: {path}")


def document(checked: CheckedTrajectory, points: list[list[float]]) -> dict[str, Any]:
    """The figures as JSON; lengths in metres, SI throughout."""
    extrema = checked.driven.extrema
    segments = checked.trajectory.segments
    return {
        "duration_s": checked.trajectory.duration,
        "segments": len(segments),
        "bytes": serial_bytes(segments),
        "length_m": sum(stretch.length for stretch in checked.stretches),
        "curves": curves(checked.stretches),
        "turns": max(len(checked.stretches) - 1, 0),
        "max_deviation_m": checked.deviation,
        "max_speed": extrema.speed,
        "max_acceleration": extrema.acceleration,
        "max_jerk": extrema.jerk,
        "max_turn_rate": extrema.turn_rate,
        "max_turn_acceleration": extrema.turn_acceleration,
        "max_turn_jerk": extrema.turn_jerk,
        "max_lateral_acceleration": extrema.lateral,
    }


def curves(stretches: Sequence[Stretch]) -> int:
    """How many curves and bends there are, each from straight to straight."""
    pieces = [piece for stretch in stretches for piece in stretch.pieces]
    return sum(bool(here.parts) and not here.curvature and not here.curvature_rate for here in pieces)


def text(result: dict[str, Any]) -> str:
    """The figures for a person."""
    return "\n".join(
        [
            f"{result['length_m']:.3f} m in {result['duration_s']:.2f} s: {result['segments']} segments, "
            f"{result['bytes']} bytes on the serial line",
            f"{result['curves']} corners rounded, {result['turns']} turned on the spot, "
            f"at most {1e3 * result['max_deviation_m']:.1f} mm beside the path",
            f"at most {result['max_speed']:.3f} m/s, {result['max_acceleration']:.3f} m/s², "
            f"{result['max_jerk']:.2f} m/s³, {result['max_lateral_acceleration']:.3f} m/s² to the side, "
            f"{result['max_turn_rate']:.3f} rad/s",
        ]
    )
