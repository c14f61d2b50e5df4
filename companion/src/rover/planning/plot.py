"""A plan as a picture (figure 10 of the paper): map, tree, path, start and goals."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rover.errors import BadInput
from rover.planning.fields import CircleField, Field, GridField
from rover.planning.result import PlanResult

Edges = NDArray[np.float64]  # (N, 2, 2): both ends of each edge of the tree, metres
LONGER_SIDE = 900
MARGIN = 24
WHITE, GROUND, TREE, PATH, START, GOAL, INK = (
    (255, 255, 255),
    (70, 70, 70),
    (225, 185, 140),
    (40, 40, 210),
    (60, 150, 40),
    (0, 140, 255),
    (30, 30, 30),
)  # blue, green, red


def draw(
    field: Field,
    start: tuple[float, float],
    goals: list[tuple[float, float]],
    result: PlanResult,
    robot_radius: float,
    tree: Edges | None = None,
) -> NDArray[np.uint8]:
    """(rows, columns, 3), y upwards; goals carry their number as given, the path is as wide as a pen, not the robot."""
    left, bottom, right, top = field.bounds
    scale = LONGER_SIDE / max(right - left, top - bottom)
    columns, rows = (max(1, round(side * scale)) for side in (right - left, top - bottom))

    def pixel(point: NDArray[np.float64] | tuple[float, float]) -> tuple[int, int]:
        return MARGIN + round((point[0] - left) * scale), MARGIN + rows - round((point[1] - bottom) * scale)

    picture = np.full((rows + 2 * MARGIN, columns + 2 * MARGIN, 3), WHITE, dtype=np.uint8)
    inner = picture[MARGIN : MARGIN + rows, MARGIN : MARGIN + columns]
    if isinstance(field, GridField):
        blocked = np.flipud(field.blocked).astype(np.uint8)
        inner[cv2.resize(blocked, (columns, rows), interpolation=cv2.INTER_NEAREST) > 0] = GROUND
    elif isinstance(field, CircleField):
        for x, y, radius in field.obstacles:
            cv2.circle(picture, pixel((x, y)), round(radius * scale), GROUND, cv2.FILLED, cv2.LINE_AA)
    for a, b in tree if tree is not None else ():
        cv2.line(picture, pixel(a), pixel(b), TREE, 1, cv2.LINE_AA)
    points = np.array([pixel(point) for point in result.path], dtype=np.int32)
    cv2.polylines(picture, [points], False, PATH, 2, cv2.LINE_AA)
    reach = max(3, round(robot_radius * scale))
    cv2.circle(picture, pixel(start), reach, START, 2, cv2.LINE_AA)
    for number, goal in enumerate(goals, start=1):
        x, y = pixel(goal)
        cv2.drawMarker(picture, (x, y), GOAL, cv2.MARKER_STAR, 16, 2, cv2.LINE_AA)
        cv2.putText(picture, str(number), (x + 9, y - 7), cv2.FONT_HERSHEY_SIMPLEX, 0.55, INK, 1, cv2.LINE_AA)
    cv2.rectangle(picture, (MARGIN, MARGIN), (MARGIN + columns, MARGIN + rows), INK, 1)
    return picture


def tree_edges(
    field: Field, start: tuple[float, float], goals: list[tuple[float, float]], robot_radius: float, seed: int
) -> Edges:
    """Figure 3's tree with the planner's own settings and seed, grown until all goals are met or 1,000 tries."""
    left, bottom, right, top = field.bounds
    step = 0.1 * float(np.hypot(right - left, top - bottom))
    nodes, parents, _, _ = field.native.multi_goal_tree(
        start, np.array(goals, dtype=np.float64).reshape(-1, 2), float(robot_radius), seed % 2**64, 1000, step, 0.3
    )
    pairs = [(nodes[parent], node) for node, parent in zip(nodes, parents, strict=True) if parent >= 0]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2, 2)


def save(picture: NDArray[np.uint8], path: Path) -> None:
    """Writes a PNG. Raises BadInput."""
    if path.suffix.lower() != ".png":
        raise BadInput(f"--plot {path}: the picture is a PNG; the name must end in .png")
    done, data = cv2.imencode(".png", picture)
    try:
        path.write_bytes(data.tobytes() if done else b"")
    except OSError as error:
        raise BadInput(f"--plot {path}: {error.strerror or error}") from error
