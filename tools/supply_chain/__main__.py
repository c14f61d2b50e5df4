"""Licences and bill of materials.

python -m tools.supply_chain licences           every crate and package with its licence; fails for one not allowed
python -m tools.supply_chain licences --quiet   only what is not allowed
python -m tools.supply_chain sbom --out FILE    CycloneDX 1.6, JSON
"""

from __future__ import annotations

import argparse
import importlib.metadata
import subprocess
import sys
from pathlib import Path

from tools.supply_chain.bill import bill
from tools.supply_chain.crates import crates
from tools.supply_chain.licences import allowed, can_be_asked, objections
from tools.supply_chain.python_packages import locks, packages

ROOT = Path(__file__).parents[2]


def licences(quiet: bool) -> int:
    """Prints the report; 1 when a licence is not allowed."""
    components = crates(ROOT)
    for lock in locks(ROOT):
        found = packages(ROOT, lock)
        # What every rover runs on has to be known; an extra is looked at where it is installed.
        components |= found if lock == "run" else {each for each in found if can_be_asked(each)}
        elsewhere = 0 if lock == "run" else sum(not can_be_asked(each) for each in found)
        if elsewhere and not quiet:
            print(f"{lock}.lock: {elsewhere} packages are not installed here and were not asked", file=sys.stderr)
    wrong = objections(components, allowed(ROOT), (ROOT / "NOTICE").read_text())
    if not quiet:
        print(
            "\n".join(
                f"{each.kind:<6} {each.name:<34} {each.version:<22} {each.licence}" for each in sorted(components)
            )
        )
    print("\n".join(wrong), file=sys.stderr, end="\n" if wrong else "")
    return 1 if wrong else 0


def sbom(out: Path) -> int:
    """Of what a rover runs on and is built with: the run lock, every crate, the networks."""
    commit, at = _git("log", "-1", "--format=%H %ct").split()
    components = crates(ROOT) | packages(ROOT, "run")
    models = (ROOT / "companion" / "models").glob("*.onnx")
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(bill(components, models, importlib.metadata.version("rover"), commit, int(at)))
    print(out)
    return 0


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tools.supply_chain", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("licences").add_argument("--quiet", action="store_true")
    commands.add_parser("sbom").add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    return licences(given.quiet) if given.command == "licences" else sbom(given.out)


if __name__ == "__main__":
    sys.exit(main())
