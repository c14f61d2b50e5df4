"""docs/results/detection.md: every table, the sentences around them, and what may not be concluded."""

from __future__ import annotations

import math
from collections.abc import Callable
from statistics import median

import numpy as np
from numpy.typing import NDArray
from rover.detection.classifier import CLASSES

from tools.evaluate.figures import PAPER_F1, binomial, number, poisson, precision_recall, table
from tools.evaluate.folds import FALSE_ALARMS, Outcome, thresholds
from tools.evaluate.real import BY_LABELS, OWN, RealResults, calibrated
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
THRESHOLDS = (0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98)


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
    for split, name, outcomes in (*lines, ("pictures at random", BY_LABELS, real.dealt)):
        figures = _figures(outcomes)
        cells = [f"{number(_over(figures, key, median))} / {number(_over(figures, key, min))}" for key in FIGURES]
        rows.append([split, name, *cells])
    return table(["split", "classifier", *(f"{h}, median / worst" for h in HEAD)], rows)


def curve_table(real: RealResults) -> str:
    """Pd of the same held-out zones after learning from more and more others."""
    names = [o.name for o in real.few[1]]
    every = {o.name: o for o in real.grouped[BY_LABELS]}
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


def detector_table(outcomes: list[Outcome]) -> str:
    """Whole pictures up to MAX_HEIGHT of all zones, by threshold on the uncalibrated score."""
    zones = [o for o in outcomes if o.name.startswith("zone") and o.pictures]
    mines, pictures = sum(o.mines for o in zones), sum(o.pictures for o in zones)
    rows = []
    for threshold in THRESHOLDS:
        found, false = (sum(part) for part in zip(*(o.at_threshold(threshold) for o in zones), strict=True))
        rows.append([f"{threshold:g}", binomial(found, mines), poisson(false, pictures)])
    return table(["threshold", f"Pd ({mines} mines)", f"false alarms a picture ({pictures} pictures)"], rows)


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

What the network is told, where candidates are looked for, how pictures are altered, dropout and the number of hard
candidates were chosen while looking at zones 1, 3, 4 and 7 and session A as held out (about fifteen settings in all)
and at the pictures in which no candidate lay on the mine; the weight of drawn casings and the mirror images while
looking at all folds (ten settings), and so was what teaches beside labels (five); nothing on inner folds. The figures
are therefore somewhat too good, and by how much is not known.

{folds_table(network)}

Beside others on the same splits. SVM and gradient boosting see the network's own numbers of the same candidates, at
most {MAX_ROWS} rows of unaltered pictures; the plain MLP sees 16×16 patches alone. The network that learned from
labels alone is one of the two that teach this one. Dealt out at random, neighbouring pictures of the same mine lie on
both sides: that flatters.

{rivals_table(real)}

All zones together, each box judged once by a network that never saw its zone. Surface mines are worse here
than fold by fold: a fold without them has no such F1, and its buried mines that are called surface count only here.

{pooled_table(network)}

### As a detector

Whole pictures up to {highest:g} m (as the index tells), one mine each; a detection counts when its middle lies in the
box or up to 10 cm beside it (as the boxes tell 10 cm). Scores are the networks' own, not calibrated. The threshold that
ships is chosen for a probability of detection of 0.9 in zones never seen: see the model card.

{detector_table(network)}

### Probabilities

Candidates of the zones, each zone calibrated on the others. Expected calibration error
{calibration_error(truth, p):.3f} over all, nearly all of which are plain ground and easy;
{_error_from(truth, p, 0.1):.3f} where a mine has at least
0.1, {_error_from(truth, p, 0.3):.3f} where it has at least 0.3.

{reliability_table(truth, p)}

### What is reached, and why it is not more

- The network fits what it learned from: on those pictures the shipped model has Pd {own:.2f} at {FALSE_ALARMS:g} false
  alarms a picture. With pictures dealt out at random Pd is {dealt:.2f}, with labels alone. What is missing is missing
  on new ground.
- Candidates: of the {mines} mines up to {MAX_HEIGHT:g} m, {near} ({near / mines:.1%}) have a candidate that would count
  and {fitting} ({fitting / mines:.1%}) one of their own place and size. The others are casings and cut turf as bright
  as the grass around them and hardly larger than its tufts.
- There are only four buried mines and two on the surface to learn from; a fold that holds a surface zone out has seen
  one casing. Pd with fewer buried zones to learn from, with labels alone:

{curve_table(real)}

{_beside_boosting(real)}- Tried with labels alone: candidates of one mine together vote no better than the best of them
  (zone 7). Where the second loudest spot of a picture lowers the score of all, Pd of five of eight folds rises by 0.01
  to 0.07. That is not used: these pictures hold one mine each, ground may hold more.
- The mean over four mirror images is used, that over quarter turns too is not: with labels alone Pd of session A falls
  by 0.2, for the pictures are stretched along one axis. Dropout within the network, zones of equal weight, less weight
  for the patches and samples without weights gave nothing on zone 4 and session A, and clipping the network's input
  when it is asked, as when it learns, nothing on zones 3, 4 and 7 and session A.
- The scale hardly helps: leaving out what is not 0.08 to 0.7 m wide, or a prior on the width, changes median Pd by
  about 0.01 to 0.02, with labels alone.
- Gradient boosting goes wrong at other mines than a network does. The network learns half from labels and half from
  the mean of what a second network and boosting say. With labels alone (mean of two seeds) medians were mine 0.92,
  surface 0.63, buried 0.86 and Pd 0.79, Pd was 0.80 as a mean of folds and 0.84 over all zones; surface differs
  by 0.05 from seed to seed. Taught so, Pd is 0.81 as a mean of folds and 0.85 over all zones, and mine and buried gain
  0.02 and 0.05 in the median; the gain of Pd is little more than seeds differ by. A second network and boosting asked
  together reach mine 0.95, surface 0.63, buried 0.94 and Pd 0.82, 0.87 over all zones. That is not used: the network is
  to be the paper's.
- Boosting alone as the teacher costs surface mines (zone 4: 0.37), and boosting with the network's weights gains mines
  against background but no Pd. Networks of other seeds asked together are no better than one.
- Surface against buried is a trade: a unit less of logit for surface gives means of buried 0.05 more, of mine and Pd
  0.01 more, and of surface 0.12 less.
- Kinds are told apart worse than mines from ground: many buried mines are called surface ones, since most casings that
  the network knows were drawn and cut turf is as even as they are.
- Seen by eye (the 28 worst pictures of zone 7 and of session A, with labels alone), misses are of two sorts: mines
  of the grass's own brightness, and pictures of session A whose detail was brought out until mines and stones differ in
  texture alone; a person finds most of the latter and few of the former. False alarms are bare soil, stones and small
  bright tufts.
- Index and labels disagree at places: copies of one picture with and without boxes, and boxes of neighbouring zones
  whose depth is not told. Those count as mines of unknown kind here and in no figure of a kind."""


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
