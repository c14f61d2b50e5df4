"""docs/results/detection.md: every table, the sentences around them, and what may not be concluded."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import median

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES

from tools.evaluate.figures import PAPER_F1, number, precision_recall, table
from tools.evaluate.folds import FALSE_ALARMS, Outcome, thresholds
from tools.evaluate.rates import by_flight_table, detector_table, kinds_table
from tools.evaluate.real import OWN, RealResults, calibrated
from tools.evaluate.rivals import BOOSTING, MAX_ROWS
from tools.train.measure import calibration_error
from tools.train.picture.hits import MAX_HEIGHT
from tools.train.picture.samples import BACKGROUND, MINE_UNKNOWN, SURFACE

FIGURES = ("mine", "surface", "buried", "pd", "pd strict")
ASKED = {"mine": 0.95, "surface": 0.85, "buried": 0.90, "pd": 0.95, "pd strict": 0.95}
HEAD = [
    "mine against background, F1",
    "surface, F1",
    "buried, F1",
    f"Pd at {FALSE_ALARMS:g} false alarms a picture, with halo",
    "the same, box alone",
]


def _figures(outcomes: list[Outcome]) -> list[dict[str, float]]:
    """Of every fold, at the threshold that the others ask for."""
    return [o.figures(threshold) for o, threshold in zip(outcomes, thresholds(outcomes), strict=True)]


def folds_table(outcomes: list[Outcome]) -> str:
    """One line a fold, then the median and the worst."""
    figures = _figures(outcomes)
    rows = [[o.name, *(number(each[key]) for key in FIGURES)] for o, each in zip(outcomes, figures, strict=True)]
    rows += [[name, *(number(_over(figures, key, how)) for key in FIGURES)] for name, how in _SUMMARIES]
    rows.append(["asked for", *(number(ASKED[key]) for key in FIGURES)])
    return table(["held out", *HEAD], rows)


def rivals_table(real: RealResults) -> str:
    """Median and worst fold of each classifier, grouped and dealt out at random."""
    lines = [("zone or session held out", name, outcomes) for name, outcomes in real.grouped.items()]
    rows = []
    for split, name, outcomes in (*lines, ("pictures at random", OWN, real.dealt)):
        figures = _figures(outcomes)
        cells = [f"{number(_over(figures, key, median))} / {number(_over(figures, key, min))}" for key in FIGURES]
        rows.append([split, name, *cells])
    return table(["split", "classifier", *(f"{h}, median / worst" for h in HEAD)], rows)


def curve_table(real: RealResults) -> str:
    """Pd of the same held-out zones after learning from more and more others."""
    names = [o.name for o in real.few[1]]
    every = {o.name: o for o in real.grouped[OWN]}
    rows = [[str(count), *(number(o.pd_at(FALSE_ALARMS)) for o in outcomes)] for count, outcomes in real.few.items()]
    rows.append(["all six", *(number(every[name].pd_at(FALSE_ALARMS)) for name in names)])
    return table(["zones learned from", *(f"{name} held out: {HEAD[3]}" for name in names)], rows)


def pooled_table(outcomes: list[Outcome]) -> str:
    """Table 1 of the paper, over all zones: each labelled box is judged once, by a network that never saw its zone."""
    zones = [o for o in outcomes if o.name.startswith("zone")]
    truth = np.concatenate([o.truth for o in zones])
    answer = np.concatenate([o.answers(t) for o, t in zip(zones, thresholds(zones), strict=True)])
    known = truth != MINE_UNKNOWN
    rows = []
    for index, name in enumerate(CLASSES):
        if index < SURFACE:
            continue
        is_it, said = truth[known] == index, answer[known] == index
        precision, recall = precision_recall(is_it, said)
        score = 2 * precision * recall / max(precision + recall, 1e-9)
        paper = number(PAPER_F1[name] / 100) if name in PAPER_F1 else "–"
        counts = [str(int(((answer[known] == other) & is_it).sum())) for other in range(SURFACE, BACKGROUND + 1)]
        rows.append([name, *counts, number(precision), number(recall), number(score), paper])
    return table(
        ["truth", *(f"called {n}" for n in CLASSES[SURFACE:]), "precision", "recall", "F1", "F1 in the paper"], rows
    )


def reliability_table(truth: NDArray[np.int64], p: NDArray[np.floating]) -> str:
    """How often an answer of some probability is right."""
    top, right = p.max(axis=1), p.argmax(axis=1) == truth
    rows = []
    for low in np.arange(0.3, 1.0, 0.1):
        here = (top >= low) & (top < low + 0.1 + 1e-9)
        if here.any():
            shares = [number(float(values[here].mean())) for values in (top, right)]
            rows.append([f"{low:.1f} to {low + 0.1:.1f}", str(here.sum()), *shares])
    return table(["probability", "candidates", "mean probability", "right"], rows)


def real_section(real: RealResults) -> str:
    """Everything about the pictures."""
    network = real.grouped[OWN]
    truth, p = calibrated(network)
    near, fitting, mines = real.ceiling
    own = real.trained_on.pd_at(FALSE_ALARMS)
    dealt = median(o.pd_at(FALSE_ALARMS) for o in real.dealt)
    highest = MAX_HEIGHT
    return f"""## Real pictures

Each zone, then each session, held out whole; the network is trained on the rest (`tools/train`) and judges what it
never saw. Patches are the labelled boxes and three windows of their size beside each; a patch is called a mine from the
probability on that does best in the other folds. The two surface zones are of session B: with session B held out, every
casing that the network knows was drawn.

How pictures are altered, which ground is learned from and what counts how much was chosen long before, while looking
at these folds, with other numbers as input. What the network is told now was chosen on inner folds alone: three
networks that never saw two zones judged either of them, and the folds below were not looked at. Means of those inner
folds, of one seed, Pd at 0.3 false alarms a picture and F1; the code for what was not chosen is gone:

| what the network is told | rounds of the pictures | Pd | mine | surface | buried |
|---|---|---|---|---|---|
| patches, gradients and circles, 804 numbers, as before | 2 | 0.77 | 0.91 | 0.76 | 0.75 |
| stage 11, at and within the spot, three scales | 2 | 0.89 | 0.93 | 0.80 | 0.91 |
| the same | 5 | 0.92 | 0.93 | 0.78 | 0.91 |
| stage 11, at scales that go with the spot's size | 5 | 0.89 | 0.91 | 0.72 | 0.88 |
| stage 8, at and within the spot, three scales | 5 | 0.91 | 0.95 | 0.81 | 0.92 |
| stage 8, at, within and beside the spot, three scales (chosen) | 5 | 0.92 | 0.95 | 0.76 | 0.93 |

{folds_table(network)}

Seeds differ: Pd of these folds at 0.3 false alarms a picture is 0.93 in the median and 0.83 at worst with seed 1, 0.91
and 0.81 with seed 2 (both without rivals, same samples).

Beside others on the same splits. SVM and gradient boosting see the network's own numbers of the same candidates, at
most {MAX_ROWS} rows of unaltered pictures; the plain MLP sees 16×16 patches alone. Dealt out at random, neighbouring
pictures of the same mine lie on both sides: that flatters.

{rivals_table(real)}

All zones together, each box judged once by a network that never saw its zone. Surface mines are worse here
than fold by fold: a fold without them has no such F1, and its buried mines that are called surface count only here.

{pooled_table(network)}

### As a detector

Whole pictures up to {highest:g} m (as the index tells), one mine each; a detection counts when its middle lies in the
box or up to 10 cm beside it (as the boxes tell 10 cm). Scores are the networks' own, not calibrated. 95 % intervals:
flights, all pictures of one zone in one session, are drawn again, for pictures of one flight show one mine on one
ground. The ground that a picture shows is told by its height; as heights below 3 m are unreliable, false alarms per m²
are of pictures from 3 m on. The threshold that ships is on the model card. How many false alarms it lets through
was lowered once these folds had been seen: on new flights the upper end of its interval is the better guess.

{detector_table(network, real.records)}

By what is to be found, where {FALSE_ALARMS:g} false alarms a picture are let through in its zone:

{kinds_table(network, real.records)}

By flight, at the same rate. The index tells the temperature at the middle of each picture: its median is the nearest
to a thermal state that is known.

{by_flight_table(network, real.records)}

### Probabilities

Candidates of the zones, each zone calibrated on the others. Expected calibration error
{calibration_error(truth, p):.3f} over all, nearly all of which are plain ground and easy;
{_error_from(truth, p, 0.1):.3f} where a mine has at least
0.1, {_error_from(truth, p, 0.3):.3f} where it has at least 0.3.

{reliability_table(truth, p)}

### What is reached, and why it is not more

- The network fits what it learned from: on those pictures the shipped model has Pd {own:.2f} at {FALSE_ALARMS:g} false
  alarms a picture. With pictures dealt out at random Pd is {dealt:.2f}.
- Candidates: of the {mines} mines up to {MAX_HEIGHT:g} m, {near} ({near / mines:.1%}) have a candidate that would count
  and {fitting} ({fitting / mines:.1%}) one of their own place and size. The others are casings and cut turf as bright
  as the grass around them and hardly larger than its tufts.
- There are only four buried mines and two on the surface to learn from; a fold that holds a surface zone out has seen
  one casing. Pd with fewer buried zones to learn from:

{curve_table(real)}

{_beside_boosting(real)}- Mirror images are not asked together: that would cost the features of four pictures.
- Index and labels disagree at places: copies of one picture with and without boxes are one picture here, where it is
  learned from and where it is judged, and boxes of neighbouring zones whose depth is not told count as mines of unknown
  kind and in no figure of a kind."""


def _beside_boosting(real: RealResults) -> str:
    """What gradient boosting with the same numbers tells about the network."""
    boosted = real.grouped.get(BOOSTING)
    if boosted is None:
        return ""
    theirs, own = (_over(_figures(o), "pd", median) for o in (boosted, real.grouped[OWN]))
    verdict = "Another form of classifier does not close the gap" if theirs < own + 0.05 else "The numbers hold more"
    return f"""- Gradient boosting with the same numbers and at most {MAX_ROWS} rows of unaltered pictures has a
  median Pd of {theirs:.2f}, the network {own:.2f}. {verdict}.
"""


def _error_from(truth: NDArray[np.int64], p: NDArray[np.floating], least: float) -> float:
    """Expected calibration error of the candidates that are mines with at least this probability."""
    likely = 1.0 - p[:, -1] >= least
    return calibration_error(truth[likely], p[likely])


def _over(figures: list[dict[str, float]], key: str, how: Callable[[list[float]], float]) -> float:
    values = [each[key] for each in figures if not math.isnan(each[key])]
    return how(values) if values else math.nan


_SUMMARIES = (("**median**", median), ("**worst**", min))
