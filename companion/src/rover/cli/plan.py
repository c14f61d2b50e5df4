"""`rover plan`: a path through goals on a map, without driving it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput, NoPath
from rover.vehicle import STANDARD

if TYPE_CHECKING:
    from rover.planning.result import PlanResult

HELP = """Plan a path from a start through goals.

FILE is a field of circles (.toml), a map_server map (.yaml) or a MovingAI map (.map); unknown ground is blocked unless
--unknown free. Points are X,Y in metres. Goals are visited as given unless --any-order. Without --budget-ms planning
ends with what the algorithm finds at once; a budget never makes a plan longer. Exit code 4 when a goal cannot be
reached.

\b
Algorithms:
  best          a small tree for a quick path, A* and, among circles, exact tangents for a short one; within a budget
                then string pulling, RRT-Connect and random shortcuts
  rrt           one tree a goal, without a goal bias; within a budget again and again, the shortest path counts
  goal-seeking  the same with a goal bias
  multi-goal    one tree towards all goals; within a budget as rrt
  rrt-star      one RRT* a goal, which goes on rewiring within its budget
Where a tree finds no path, a lattice is searched. --json lists the stages that ran.

\b
Examples:
  rover plan --map field.toml --start 2,0.5 --goal 2,2.5 --goal 1.2,3.5 --budget-ms 50
  rover plan --map office.yaml --start 1,1 --goal 4,2 --algorithm rrt-star --budget-ms 200 --json
  rover plan --map field.toml --start 2,0.5 --goal 2,2.5 --goal 1.2,3.5 --plot plan.svg
  rover plan --map arena.map --resolution 0.1 --start 1,1 --goal 4,4 --algorithm rrt --robot-radius 0
"""


def command(
    map_file: Annotated[Path, typer.Option("--map", metavar="FILE", help="Map: .toml, .yaml or .map.")],
    start: Annotated[str, typer.Option(metavar="X,Y", help="Where to start.")],
    goal: Annotated[list[str], typer.Option(metavar="X,Y", help="Where to go; give it once for each goal.")],
    algorithm: Annotated[
        str, typer.Option(metavar="NAME", help="best, rrt, rrt-star, goal-seeking or multi-goal.")
    ] = "best",
    robot_radius: Annotated[float, typer.Option(metavar="R", help="Radius of the robot, metres.")] = STANDARD.radius,
    seed: Annotated[int, typer.Option(min=0, help="Fixes every random choice.")] = 0,
    budget_ms: Annotated[
        float | None, typer.Option(metavar="B", help="Improve the path until so many milliseconds are over.")
    ] = None,
    any_order: Annotated[bool, typer.Option("--any-order", help="Let the planner choose the order.")] = False,
    resolution: Annotated[float, typer.Option(metavar="M", help="Metres per cell of a .map file.")] = 1.0,
    unknown: Annotated[
        Literal["blocked", "free"], typer.Option(help="Ground of which a .yaml map says nothing.")
    ] = "blocked",
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Plot map, path, goals and multi-goal's tree: .svg or .png.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.planning.fields import load_field
    from rover.planning.planner import plan

    begin = point("--start", start)
    goals = [point("--goal", each) for each in goal]
    field = load_field(map_file, resolution, unknown, say)
    if plot is not None:
        from rover.planning.plot import check_name

        check_name(plot)
    result = plan(
        field,
        begin,
        goals,
        algorithm=algorithm,
        robot_radius=robot_radius,
        seed=seed,
        budget_ms=budget_ms,
        any_order=any_order,
    )
    if plot is not None:
        from rover.planning.plot import draw, save, tree_edges

        one_tree = algorithm == "multi-goal"
        tree = tree_edges(field, begin, goals, robot_radius, seed) if one_tree else None
        save(draw(field, begin, goals, result, robot_radius, tree), plot)
        say(f"plotted: {plot}")
    if as_json:
        write_json(document(result))
    elif result.ok:
        write_text(text(result))
    if not result.ok:
        say(f"no path: {result.reason}")
        return NoPath.exit_code
    return 0


def point(option: str, given: str) -> tuple[float, float]:
    """X,Y in metres. Raises BadInput."""
    try:
        x, y = (float(part) for part in given.split(","))
    except ValueError:
        raise BadInput(f"{option} {given}: two numbers X,Y in metres are expected, such as 2.0,0.5") from None
    if not (math.isfinite(x) and math.isfinite(y)):
        raise BadInput(f"{option} {given}: finite numbers are expected")
    return x, y


def document(result: PlanResult) -> dict[str, Any]:
    """The plan as JSON; `order` counts the goals as given, from 0."""
    return {
        "status": result.status,
        "reason": result.reason,
        "algorithm": result.algorithm,
        "order": list(result.order),
        "unreachable": list(result.unreachable),
        "path": result.path.tolist(),
        "length_m": result.length,
        "iterations": result.iterations,
        "nodes": result.nodes,
        "time_ms": result.time_ms,
        "first_solution_ms": result.first_solution_ms,
        "stages": [
            {"name": stage.name, "time_ms": stage.time_ms, "iterations": stage.iterations} for stage in result.stages
        ],
    }


def text(result: PlanResult) -> str:
    """The plan for a person: figures, the order as in the JSON, then a waypoint a line."""
    order = ", ".join(map(str, result.order))
    head = (
        f"{result.algorithm}: {result.length:.3f} m, {len(result.path)} points, goals in the order {order} (from 0), "
        f"{result.iterations} iterations, {result.nodes} nodes, {result.time_ms:.1f} ms"
    )
    return "\n".join([head, *(f"  {x:.3f}, {y:.3f}" for x, y in result.path.tolist())])
