"""Where a file is asked for, a pipe that nobody writes to and a device without an end are refused at once."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import cv2
import numpy as np
import pytest

LIMIT_S = 20
COMMANDS = {
    "run": ["run", "IT"],
    "run --resume": ["run", "demo", "--resume", "IT"],
    "plan": ["plan", "--map", "IT", "--start", "0,0", "--goal", "1,1"],
    "plan toml": ["plan", "--map", "IT.toml", "--start", "0,0", "--goal", "1,1"],
    "plan yaml": ["plan", "--map", "IT.yaml", "--start", "0,0", "--goal", "1,1"],
    "plan map": ["plan", "--map", "IT.map", "--start", "0,0", "--goal", "1,1"],
    "trajectory": ["trajectory", "IT"],
    "trajectory --map": ["trajectory", "PATH", "--map", "IT.yaml"],
    "decode": ["decode", "IT"],
    "grid": ["grid", "IT", "--out", "OUT.yaml"],
    "register": ["register", "PICTURE", "IT"],
    "track --camera": ["track", "FOLDER", "--camera", "IT.toml"],
    "stitch": ["stitch", "PICTURE", "IT", "--out", "OUT.png"],
    "detect": ["detect", "IT"],
    "detect --camera": ["detect", "PICTURE", "--camera", "IT.toml"],
    "calibrate": ["calibrate", "IT", "--board", "5x4", "--square", "0.1"],
    "calibrate --ground": ["calibrate", "--camera", "lepton-160", "--ground", "IT"],
    "flash": ["flash", "--file", "IT"],
    "replay": ["replay", "IT"],
    "recover": ["recover", "IT", "--out", "OUT"],
    "hil run": ["hil", "run", "IT"],
    "hil serve": ["hil", "serve", "IT"],
    "tell": ["tell", "IT", "state"],
}

# Those that were told of a missing file when there was something else.
SAYS_WHAT_IT_IS = ("decode", "grid", "register", "stitch", "detect", "calibrate")


@pytest.fixture
def limit() -> Iterator[None]:
    """Ends a command that reads for ever."""

    def over(_: int, __: FrameType | None) -> None:
        raise TimeoutError(f"it had not ended after {LIMIT_S} s")

    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(LIMIT_S)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    for suffix in (".toml", ".yaml", ".map"):
        os.mkfifo(f"{path}{suffix}")
    return path


@pytest.fixture
def device(tmp_path: Path) -> Path:
    path = tmp_path / "zero"
    for suffix in ("", ".toml", ".yaml", ".map"):
        Path(f"{path}{suffix}").symlink_to("/dev/zero")
    return path


def line(command: str, it: Path, folder: Path) -> list[str]:
    cv2.imwrite(str(folder / "picture.png"), np.full((60, 80), 20_000, np.uint16))
    (folder / "path.json").write_text("[[0, 0], [1, 0]]")
    (folder / "frames").mkdir()
    stand_for = {
        "PATH": folder / "path.json",
        "PICTURE": folder / "picture.png",
        "FOLDER": folder / "frames",
    }
    words = []
    for word in COMMANDS[command]:
        if word.startswith("IT"):
            words.append(f"{it}{word[2:]}")
        elif word.startswith("OUT"):
            words.append(str(folder / f"out{word[3:]}"))
        else:
            words.append(str(stand_for.get(word, word)))
    return words


@pytest.mark.usefixtures("limit")
@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_no_file_is_refused_in_one_line(
    rover, request: pytest.FixtureRequest, tmp_path: Path, command: str, kind: str
) -> None:
    it: Path = request.getfixturevalue(kind)
    result = rover(*line(command, it, tmp_path))
    assert result.code == 2, result.err
    assert str(it) in result.err
    if command in SAYS_WHAT_IT_IS:
        assert ": is a " in result.err
    said = [line for line in result.err.splitlines() if "laying the field" not in line]
    assert len(said) == 1, result.err
