"""Write the Rust and Python tables of what goes over a wire: messages from protocol/rover.dbc, the tick between a
simulated rig and its firmware from protocol/rig_tick.toml, the firmware's parameters from protocol/parameters.toml.

Run `python -m tools.generate` after a change of either; `--check` only compares and exits with 1 when a checked-in
file is out of date. Every message is byte-aligned little-endian, which is checked here, so that both codecs stay
trivial.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cantools

from tools.generate import parameters, python_messages, python_tick, rust_messages, rust_tick, schema, tick_records

PROTOCOL = Path(__file__).resolve().parents[2] / "protocol"
ROOT = PROTOCOL.parent
DOCUMENT = ROOT / "docs" / "reference" / "protocol.md"
RUST, PYTHON = PROTOCOL / "rust" / "src", PROTOCOL / "python" / "rover_protocol"


def generated() -> dict[Path, str]:
    """What each generated file must hold. Raises ValueError or cantools.Error for a description that is wrong."""
    messages = schema.load(PROTOCOL / "rover.dbc")
    ticks = tick_records.load(PROTOCOL / "rig_tick.toml")
    described = parameters.load(PROTOCOL / "parameters.toml")
    return {
        ROOT / "firmware" / "core" / "src" / "parameter_table.rs": parameters.render_rust(described),
        PYTHON / "parameters.py": parameters.render_python(described),
        DOCUMENT: parameters.render_document(described, DOCUMENT.read_text(encoding="utf-8")),
        RUST / "messages.rs": rust_messages.render(messages),
        PYTHON / "messages.py": python_messages.render(messages),
        RUST / "rig_tick.rs": rust_tick.render(ticks),
        PYTHON / "rig_tick.py": python_tick.render(ticks),
    }


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tools.generate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="only compare; exit with 1 on a difference")
    options = parser.parse_args(arguments)
    try:
        files = generated()
    except (ValueError, cantools.Error) as error:
        print(error, file=sys.stderr)
        return 2
    changed = {
        path: text for path, text in files.items() if not path.exists() or path.read_text(encoding="utf-8") != text
    }
    for path, text in changed.items():
        print(f"{path.relative_to(ROOT)}: {'out of date' if options.check else 'written'}")
        if not options.check:
            path.write_text(text, encoding="utf-8")
    return 1 if options.check and changed else 0


if __name__ == "__main__":
    sys.exit(main())
