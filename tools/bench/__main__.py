"""`python -m tools.bench NAME [OPTIONS]`: runs one measurement."""

from __future__ import annotations

import sys

from tools.bench import detector, missions, planner, protocol, trajectory, vision

BENCHES = {
    "detector": detector.main,
    "missions": missions.main,
    "planner": planner.main,
    "protocol": protocol.main,
    "trajectory": trajectory.main,
    "vision": vision.main,
}


def main() -> int:
    """Dispatches to the measurement named first; lists them otherwise."""
    if len(sys.argv) < 2 or sys.argv[1] not in BENCHES:
        print(f"usage: python -m tools.bench {{{','.join(BENCHES)}}} [OPTIONS]", file=sys.stderr)
        return 2
    return BENCHES[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    sys.exit(main())
