"""Table 4 of the paper beside the same four algorithms here, first solutions on the paper's field."""

from __future__ import annotations

import numpy as np
from rover.planning import plan

from tools.bench.planner.scenes import PAPER_GOALS, PAPER_START, paper_field

# As printed: seconds, iterations, nodes, metres. All but the last algorithm were run to goal 1 alone.
PAPER = {
    "rrt": (0.784, 270, 333, 4.913),
    "rrt-star": (0.635, 256, 465, 4.138),
    "goal-seeking": (0.494, 180, 113, 4.233),
    "multi-goal": (1.2, 210, 108, 4.0),
}


def table(seeds: int) -> str:
    """Medians over the seeds; ours are before any time for improvement, after shortcuts."""
    lines = [
        "| algorithm | goals | time s, paper | ours | iterations, paper | ours | nodes, paper | ours | length m, paper "
        "| ours |",
        "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for algorithm, (seconds, iterations, nodes, metres) in PAPER.items():
        goals = PAPER_GOALS if algorithm == "multi-goal" else PAPER_GOALS[:1]
        runs = [plan(paper_field(), PAPER_START, goals, algorithm=algorithm, seed=seed) for seed in range(seeds)]
        ours = [np.median([getattr(run, name) for run in runs]) for name in ("iterations", "nodes", "length")]
        took = 1e-3 * np.median([run.first_solution_ms for run in runs])
        lines.append(
            f"| {algorithm} | {' and '.join(str(n + 1) for n in range(len(goals)))} | {seconds:g} | {took:.6f} "
            f"| {iterations} | {ours[0]:.0f} | {nodes} | {ours[1]:.0f} | {metres:.3f} | {ours[2]:.3f} |"
        )
    return "\n".join(lines)
