"""Trains one of the two networks and writes it with its section of the model card.

python -m tools.train ground --help       for candidates in kelvin and metres, from synthetic fields
python -m tools.train pictures --help     for pictures that know neither, from real pictures (--data)
"""

from __future__ import annotations

import argparse
import sys
import warnings

from rover.detection.classifier import GROUND, PICTURES
from sklearn.exceptions import ConvergenceWarning

from tools.train.ground import train as ground
from tools.train.picture import train as pictures

COMMANDS = {GROUND: ground.main, PICTURES: pictures.main}


def main() -> int:
    """Hands the arguments behind the network's name on to its training."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.train", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("network", choices=COMMANDS)
    name = parser.parse_args(sys.argv[1:2]).network
    warnings.simplefilter("ignore", ConvergenceWarning)
    COMMANDS[name](sys.argv[2:])
    return 0


if __name__ == "__main__":
    sys.exit(main())
