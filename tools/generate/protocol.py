"""Write the Rust and Python message tables from protocol/rover.dbc.

Run `python tools/generate/protocol.py` after a change of the DBC; `--check` only compares and exits with 1 when
a checked-in file is out of date. Every message is byte-aligned little-endian, which is checked here, so that
both codecs stay trivial.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cantools
import python_messages
import rust_messages
from schema import load

ROOT = Path(__file__).resolve().parents[2]
DBC = ROOT / "protocol" / "rover.dbc"
OUTPUTS = {
    ROOT / "protocol" / "rust" / "src" / "messages.rs": rust_messages.render,
    ROOT / "protocol" / "python" / "rover_protocol" / "messages.py": python_messages.render,
}


def outdated() -> list[Path]:
    """Generated files that differ from what the DBC yields now."""
    schema = load(DBC)
    return [
        path
        for path, render in OUTPUTS.items()
        if not path.exists() or path.read_text(encoding="utf-8") != render(schema)
    ]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare; exit with 1 on a difference")
    options = parser.parse_args(arguments)
    try:
        changed = outdated()
    except (ValueError, cantools.Error) as error:
        print(f"{DBC.name}: {error}", file=sys.stderr)
        return 2
    for path in changed:
        print(f"{path.relative_to(ROOT)}: {'out of date' if options.check else 'written'}")
        if not options.check:
            path.write_text(OUTPUTS[path](load(DBC)), encoding="utf-8")
    return 1 if options.check and changed else 0


if __name__ == "__main__":
    sys.exit(main())
