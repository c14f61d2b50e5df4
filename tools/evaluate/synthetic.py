"""The part of docs/results/detection.md about synthetic fields: single looks, their limits, and whole drives."""

from __future__ import annotations

from pathlib import Path

from rover.detection.classifier import Classifier

from tools.evaluate import limit, timing
from tools.evaluate.driven import CHOSEN, curve, drives, places, split
from tools.train.ground.fields import HELD_OUT_HOURS
from tools.train.ground.train import FIRST_DRIVE, MIN_TESTED_KELVIN, tests
from tools.train.measure import by_contrast, looks_as_markdown


def synthetic_section(ground: Classifier, drive_fields: int, test_fields: int, cache: Path | None) -> str:
    """Markdown; `drive_fields` fields are driven over, each test has `test_fields` at most."""
    hours = ", ".join(f"{begin:g} to {end:g}" for begin, end in HELD_OUT_HOURS)
    floor = MIN_TESTED_KELVIN
    parts = [
        f"""## Synthetic fields

### Single looks

A mine of at least {floor:g} K at the surface counts once for every look that it is in view of, with the most
mine-like answer in its halo (half-extent plus 10 cm), and as called background where no candidate lies there. Obstacles
and ground count by candidates, all of them. Nothing was learned from the hours
{hours}. 95 % intervals: whole fields drawn again. Asked for are 0.97 for obstacle, surface and buried, and an expected
calibration error of 0.03."""
    ]
    seen = tests(cache, test_fields)
    for name, looks in seen.items():
        p = ground.predict(looks.vectors)
        parts.append(f"**{name}**\n\n{looks_as_markdown(looks, p, floor)}\n\n{by_contrast(looks, p)}")
    searching = "\n".join(
        f"- {name}: best F1 by strength alone {limit.searching_f1(looks):.2f}." for name, looks in seen.items()
    )
    parts.append(
        f"""### What hides weak buried mines

`.venv/bin/python -m tools.evaluate.limit --fields {test_fields}`: the soil's own texture. The table has d',
the distance of a mine from bare ground in standard deviations, for the best linear observer, who is told where to
look, how deep the mine lies and which hour it is; the best F1 is his, at any threshold, if the ground were Gaussian.
He does not reach 0.97 either: half of a kelvin above a mine is as much as soil without a mine often has. Looking
again does not help, for texture stays where it is. The network is told none of these things. It has to search: the
strongest spots of a picture without a mine are chosen among all its places, and stones and damp patches are among
them. How much that costs is told by an observer who searches: every candidate's strength alone, a filter nearly as
good as the best one, at the threshold that does best on the very same looks.

{limit.report(test_fields)}

{searching}"""
    )
    runs = drives(Path(ground.path), drive_fields, FIRST_DRIVE) if drive_fields else []
    if runs:
        parts.append(
            f"""### Driven over: places

{len(runs)} fields in four soils (three were trained on) at nine hours, many looks fused into places; one
count per mine within its half-extent plus 10 cm. What is reported at {CHOSEN:g}:

{places(runs)}

95 % intervals in the next tables: binomial for Pd, Poisson for the rate.

{curve(runs)}

{split(runs)}"""
        )
    parts.append(
        "### Time\n\n`.venv/bin/python -m tools.evaluate.timing`: processor time of one core, milliseconds.\n\n"
        + timing.report()
    )
    return "\n\n".join(parts)
