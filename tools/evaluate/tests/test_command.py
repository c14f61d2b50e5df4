"""Specification: what cannot be evaluated is told in one line before anything is measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.evaluate import __main__ as command


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--out", "{}/nowhere/page.md"], "there is no folder"),
        (["--fields", "0"], "--fields and --jobs are at least 1"),
        (["--drives", "-1"], "--drives at least 0"),
        (["--ground", "{}/none.onnx", "--out", "{}/page.md"], "none.onnx: the classifier cannot be read"),
        (["--data", "{}", "--out", "{}/page.md"], "index.csv"),
    ],
)
def test_an_error_is_one_line(
    arguments: list[str],
    told: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("ROVER_DATA", raising=False)
    monkeypatch.setattr("sys.argv", ["tools.evaluate", *(a.format(tmp_path) for a in arguments)])
    assert command.main() == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert told in lines[0]
