"""The planners beside their peers, in one run.

python -m tools.bench planner --data DIR      # DIR holds maps/ with MovingAI scenarios
python -m tools.bench planner --seeds 10 --only fields
"""

from tools.bench.planner.bench import main

__all__ = ["main"]
