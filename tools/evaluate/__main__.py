"""`python -m tools.evaluate [--data DIR]`: every table of docs/results/detection.md, made anew.

Without --data the part about real pictures is left out. With it, seventeen networks and their rivals are trained.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from pathlib import Path

import cv2
from rover.detection.classifier import GROUND, PICTURES, Classifier, default_model
from rover.errors import BadInput, RoverError
from sklearn.exceptions import ConvergenceWarning

from tools.evaluate.real import OWN, evaluate_real
from tools.evaluate.report import real_section
from tools.evaluate.shown import write_worst
from tools.evaluate.synthetic import synthetic_section
from tools.train.ground.train import SOIL_TEST_FIELDS

NO_CONCLUSION = """## What may not be concluded

- That ground without an indication holds no mine. Around the two daily zero crossings mines have no contrast, deep
  mines hardly ever have any, and every table here counts such mines as missed.
- That these figures hold for other soils, casings, cameras or seasons: six real mines on one field, and fields from
  the simulator that the network was trained with (other seeds, one soil and five hours of the day held out).
- That a probability means the same elsewhere: it is calibrated for the share of mines among the candidates here.
- Anything about rates below one false alarm in some hundred square metres: the driven area is too small."""


def main() -> int:
    """Measures, writes; an expected failure is one line on stderr and its exit code."""
    try:
        _evaluate()
    except RoverError as error:
        print(f"tools.evaluate: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def _evaluate() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.evaluate", description=__doc__)
    parser.add_argument("--data", type=Path, default=os.environ.get("ROVER_DATA"), help="folder of real pictures")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="folds of real pictures that are worked at together")
    parser.add_argument("--drives", type=int, default=20, help="synthetic fields that are driven over")
    parser.add_argument("--fields", type=int, default=SOIL_TEST_FIELDS, help="most synthetic fields of each test")
    parser.add_argument("--no-rivals", action="store_true", help="this network alone")
    parser.add_argument("--cache", type=Path, help="folder that keeps the vectors for another round")
    parser.add_argument("--ground", type=Path, default=Path(default_model(GROUND)), help="a model file")
    parser.add_argument("--picture-model", type=Path, default=Path(default_model(PICTURES)), help="a model file")
    parser.add_argument("--pictures", type=Path, default=Path("runs/evaluation"), help="where real pictures are shown")
    parser.add_argument("--out", type=Path, default=Path("docs/results/detection.md"))
    options = parser.parse_args()
    warnings.simplefilter("ignore", ConvergenceWarning)
    if not options.out.parent.is_dir():
        raise BadInput(f"--out {options.out}: there is no folder {options.out.parent}; make it first")
    if options.fields < 1 or options.drives < 0 or options.jobs < 1:
        raise BadInput("--fields and --jobs are at least 1, --drives at least 0")
    ground = Classifier(options.ground, GROUND)
    shipped = Classifier(options.picture_model, PICTURES)

    sections = [_head(ground, shipped, options)]
    if options.data is not None:
        real = evaluate_real(
            Path(options.data), options.seed, options.cache, not options.no_rivals, options.jobs, shipped
        )
        write_worst(real.grouped[OWN], real.records, options.pictures)
        sections.append(real_section(real))
    sections.append(synthetic_section(ground, options.drives, options.fields, options.cache))
    sections.append(NO_CONCLUSION)
    options.out.write_text("\n\n".join(sections) + "\n", encoding="utf-8")
    print(options.out)


def _head(ground: Classifier, pictures: Classifier, options: argparse.Namespace) -> str:
    more = "".join((" --no-rivals" if options.no_rivals else "", " --data DIR" if options.data is not None else ""))
    if options.fields != SOIL_TEST_FIELDS:
        more = f" --fields {options.fields}{more}"
    return f"""# Detection: how well, and how that is known

Made by `.venv/bin/python -m tools.evaluate --seed {options.seed} --drives {options.drives}{more}`
(`make evaluate`) with OpenCV {cv2.__version__} and the networks `{ground.sha256[:12]}…` for ground and
`{pictures.sha256[:12]}…` for pictures. How they were trained stands in
[their card](../../companion/models/README.md). Pictures of the worst misses and false alarms are written to
`{options.pictures.as_posix()}`; they show data that is not part of this repository.

A candidate is a spot, hot or cold, smooth or rough, at any size that a mine can have. Where the camera knows kelvin and
metres, a thermal and an occupancy patch (paper section 3.2.1) and numbers about its surroundings tell the network about
it. Where it does not, an occupancy patch does, and what the first stages of a network for photographs see there. Both
networks have the paper's 256 and 128 units and a softmax."""


if __name__ == "__main__":
    sys.exit(main())
