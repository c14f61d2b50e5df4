"""Flash the board: the same as `rover flash`.

python -m tools.flash --port /dev/ttyACM0
"""

from __future__ import annotations

import sys

from rover.cli.main import invoke

if __name__ == "__main__":
    sys.exit(invoke(["flash", *sys.argv[1:]]))
