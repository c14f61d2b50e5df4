"""What is built for the board tells nothing of where it was built; no path, no name of a user."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILT = sorted((ROOT / "firmware" / "build").glob("*.uf2"))


@pytest.mark.skipif(not BUILT, reason="make firmware has not been run")
@pytest.mark.parametrize("file", BUILT, ids=lambda file: file.name)
def test_no_path_of_this_computer_is_in_the_firmware(file: Path) -> None:
    blocks = file.read_bytes()
    flash = b"".join(blocks[start + 32 : start + 32 + 256] for start in range(0, len(blocks), 512))
    assert len(flash) > 50_000
    cargo = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    for path in (str(ROOT), cargo, str(Path.home()) + "/"):
        assert path.encode() not in flash, path
