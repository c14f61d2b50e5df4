"""`python -m tools.train ground|pictures`: trains one of the two networks and writes it with its part of the card."""

from __future__ import annotations

import sys
import warnings

from rover.detection.classifier import GROUND, PICTURES
from sklearn.exceptions import ConvergenceWarning

from tools.train.ground import train as ground
from tools.train.picture import train as pictures

COMMANDS = {GROUND: ground.main, PICTURES: pictures.main}


def main() -> int:
    """Hands the arguments on."""
    warnings.simplefilter("ignore", ConvergenceWarning)
    chosen = COMMANDS.get(sys.argv[1]) if len(sys.argv) > 1 else None
    if chosen is None:
        names = "|".join(COMMANDS)
        print(f"python -m tools.train {names} [options]; --help after the name tells them", file=sys.stderr)
        return 2
    chosen(sys.argv[2:])
    return 0


if __name__ == "__main__":
    sys.exit(main())
