"""`rover console` before it serves anything."""

from __future__ import annotations

import importlib.util
import socket
from pathlib import Path

import pytest
from rover.cli.main import invoke


def test_without_its_extra_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    known = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "uvicorn" else known(name))
    assert invoke(["console"]) == 3
    said = capsys.readouterr().err
    assert "rover console needs uvicorn: install the extra [console], as by 'make setup-console'" in said


@pytest.mark.parametrize("listen", ["8080", "host:", "127.0.0.1:99999", "127.0.0.1:http", ""])
def test_an_address_that_is_none_is_one_line(listen: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert invoke(["console", "--listen", listen, "--runs", str(tmp_path)]) == 2
    assert f"--listen {listen}: HOST:PORT is expected" in capsys.readouterr().err


def test_a_port_that_is_taken_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        listen = f"127.0.0.1:{taken.getsockname()[1]}"
        assert invoke(["console", "--listen", listen, "--runs", str(tmp_path)]) == 2
    assert f"rover: --listen {listen}: Address already in use" in capsys.readouterr().err


def test_runs_that_are_no_folder_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "file"
    file.write_text("")
    assert invoke(["console", "--listen", "127.0.0.1:0", "--runs", str(file)]) == 2
    assert f"rover: --runs {file}: " in capsys.readouterr().err
