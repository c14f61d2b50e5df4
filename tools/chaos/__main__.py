"""A campaign of faults over missions, runs and commands. Exit code 1 when something did not hold.

python -m tools.chaos --seed 7 --minutes 60 --jobs 2           as many trials as an hour allows
python -m tools.chaos --seed 7 --first 212 --trials 1          that one again
python -m tools.chaos --seed 7 --trials 20 --kind frozen
python -m tools.chaos --seed 7 --trials 500 --keep build/chaos     the folders of what went wrong
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tools.chaos.campaign import SHARES, Campaign, table


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.chaos", description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1, help="fixes every trial but the moments, which are the clock's")
    parser.add_argument("--trials", type=int, default=10_000)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--first", type=int, default=0, help="number of the first trial")
    parser.add_argument("--jobs", type=int, default=1, help="trials at a time")
    parser.add_argument("--kind", choices=list(SHARES))
    parser.add_argument("--keep", type=Path, help="folder for what went wrong")
    given = parser.parse_args()
    done = []
    with Campaign(given.seed, given.keep) as campaign:
        for each in campaign.trials(given.trials, given.minutes, given.first, given.kind, given.jobs):
            done.append(each)
            verdict = "; ".join(each.trial.wrong) or "ok"
            line = f"{each.number}: {each.kind}: {each.trial.did}: {verdict} ({each.seconds:.1f} s)"
            print(line.encode("unicode_escape").decode(), file=sys.stderr, flush=True)
    print(f"Seed {given.seed}, {len(done)} trials from number {given.first} on.\n\n{table(done)}")
    return 1 if any(each.trial.wrong for each in done) else 0


if __name__ == "__main__":
    sys.exit(main())
