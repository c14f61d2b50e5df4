"""`python -m tools.bench NAME [OPTIONS]`: runs one measurement."""

from __future__ import annotations

import importlib
import sys

# Modules of tools.bench with `main(arguments) -> exit code`; each is imported when it is asked for.
BENCHES = (
    "bringup",
    "campaign",
    "console",
    "detector",
    "missions",
    "planner",
    "protocol",
    "trajectory",
    "unfriendly",
    "vision",
    "worlds",
)

OWN_PACKAGES = ("tools", "rover", "rover_hil", "rover_native", "rover_plant", "rover_protocol")


def main(arguments: list[str]) -> int:
    """Runs the measurement named first; 2 if there is none of that name, 3 if a package that it needs is missing."""
    if not arguments or arguments[0] not in BENCHES:
        print(f"usage: python -m tools.bench {{{','.join(BENCHES)}}} [OPTIONS]", file=sys.stderr)
        return 2
    name = arguments[0]
    try:
        return int(importlib.import_module(f"tools.bench.{name}").main(arguments[1:]))
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package in OWN_PACKAGES:
            raise
        print(f"the measurement `{name}` needs the Python package {package}: run 'make setup-dev'", file=sys.stderr)
        return 3


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
