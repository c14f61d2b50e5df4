"""The command writes pages, finds what no longer holds, and every cheap figure in docs holds."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.results import page
from tools.results.__main__ import differences, main, pages
from tools.results.run import ROOT


def write_page(folder: Path, command: str, body: str = "") -> Path:
    file = folder / "page.md"
    file.write_text(f"<!-- results cheap: {command} -->\n{body}<!-- /results -->\n", encoding="utf-8")
    return file


def test_a_page_written_is_a_page_that_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_page(tmp_path, "printf '| 1 |\\n'")
    assert main(["--check", str(file)]) == 1
    assert "the page lacks `| 1 |`" in capsys.readouterr().out
    assert main([str(file)]) == 0
    assert "\n| 1 |\n" in file.read_text(encoding="utf-8")
    assert main(["--check", str(file)]) == 0


def test_a_command_that_fails_is_named_and_the_page_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_page(tmp_path, "echo no >&2; exit 3 | cat", "old\n")
    before = file.read_text(encoding="utf-8")
    assert main([str(file)]) == 1
    assert "ended with exit code 3: no" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == before


def test_commands_on_real_data_are_left_out_without_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROVER_DATA", raising=False)
    file = write_page(tmp_path, 'ls "$ROVER_DATA" && exit 1', "old\n")
    assert main([str(file)]) == 0
    assert main(["--check", str(file)]) == 0
    assert "old\n" in file.read_text(encoding="utf-8")


def test_a_bad_marker_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "page.md"
    file.write_text("<!-- results: echo -->\n", encoding="utf-8")
    assert main([str(file)]) == 2
    assert "line 1" in capsys.readouterr().err


PAGES_WITH_CHEAP_BLOCKS = [
    file for file in pages() if any(block.cheap for block in page.blocks(file.read_text(encoding="utf-8")))
]


@pytest.mark.slow
@pytest.mark.parametrize("file", PAGES_WITH_CHEAP_BLOCKS, ids=lambda file: str(file.relative_to(ROOT)))
def test_the_cheap_figures_of_a_page_hold(file: Path) -> None:
    assert list(differences(file)) == []
