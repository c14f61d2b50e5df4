"""Trains one of the two networks and writes it with its section of the model card, or makes the features they need.

python -m tools.train ground --help       for candidates in kelvin and metres, from synthetic fields
python -m tools.train pictures --help     for pictures that know neither, from real pictures (--data)
python -m tools.train features --help     what a network for photographs sees, which the network for pictures is told
"""

from __future__ import annotations

import argparse
import sys
import warnings

from rover.detection.classifier import GROUND, PICTURES
from rover.errors import RoverError
from sklearn.exceptions import ConvergenceWarning

from tools.train.backbone import make as features
from tools.train.ground import train as ground
from tools.train.picture import train as pictures

COMMANDS = {GROUND: ground.main, PICTURES: pictures.main, "features": features.main}


def main() -> int:
    """Hands the arguments behind the network's name on to its training."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.train", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("network", choices=COMMANDS)
    name = parser.parse_args(sys.argv[1:2]).network
    warnings.simplefilter("ignore", ConvergenceWarning)
    try:
        COMMANDS[name](sys.argv[2:])
    except RoverError as error:
        print(f"tools.train: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
