"""Every block of code in README and docs does what it says: shell and Python blocks run, TOML blocks are read.

Shell blocks run line by line in a folder that holds the checkout by links and begins without `runs`; the blocks of one
page share it, so a later block may use what an earlier one has made. A comment on the line before a block excuses it:

    <!-- long -->             takes minutes: runs only when ROVER_LONG_BLOCKS is set
    <!-- not run: reason -->  needs what is not there (a board, a camera, data), or builds something
    <!-- file: name -->       the reader saves the block under this name; blocks that follow find it there
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from rover.errors import PreflightFailed
from rover.toml_file import read_toml
from rover_hil.firmware_process import find_binary

REPOSITORY = Path(__file__).resolve().parents[2]
PAGES = sorted(
    page
    for page in (*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"))
    if page.parts[-2] != "results"  # those commands are run by `make results`
)
LANGUAGES = {"sh", "toml", "python", "diff", "text", "csv", "json", "mermaid", "rust", "dbc"}
TIME_LIMIT_S = 900


@dataclass(frozen=True)
class Block:
    """A fenced block of a page: its language, its text, the line that it begins on, the comment before it."""

    page: Path
    line: int
    language: str
    text: str
    remark: str

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(REPOSITORY)}:{self.line}"


def blocks(page: Path) -> Iterator[Block]:
    """The fenced blocks of a page, in order; those inside lists are indented."""
    text = page.read_text(encoding="utf-8")
    fence = r"^(?P<indent> *)```(?P<language>\w*)\n(?P<text>.*?)^(?P=indent)```$"
    for found in re.finditer(fence, text, re.MULTILINE | re.DOTALL):
        before = text[: found.start()].rstrip("\n").rsplit("\n", 1)[-1].strip()
        remark = re.fullmatch(r"<!-- (.+) -->", before)
        yield Block(
            page,
            text.count("\n", 0, found.start()) + 1,
            found["language"],
            re.sub(rf"^{found['indent']}", "", found["text"], flags=re.MULTILINE),
            remark[1] if remark else "",
        )


EVERY = [block for page in PAGES for block in blocks(page)]


def runs(block: Block) -> bool:
    """True for a shell block that this run of the tests is to execute."""
    return (
        block.language == "sh"
        and not block.remark.startswith("not run: ")
        and (block.remark != "long" or bool(os.environ.get("ROVER_LONG_BLOCKS")))
    )


def checkout(folder: Path) -> Path:
    """Links to everything in the checkout but what runs have left there."""
    for entry in REPOSITORY.iterdir():
        if entry.name not in ("runs", ".git"):
            (folder / entry.name).symlink_to(entry)
    return folder


@pytest.mark.parametrize("block", EVERY, ids=lambda block: block.where)
def test_every_block_names_its_language(block: Block) -> None:
    assert block.language in LANGUAGES


@pytest.mark.parametrize("block", [b for b in EVERY if b.language == "sh"], ids=lambda block: block.where)
def test_every_shell_block_names_the_interpreter_in_one_way(block: Block) -> None:
    for line in block.text.splitlines():
        bare = re.search(r"(?:^|[;&|(]\s*|=\S+ )(python3?|rover|pytest|pip)\s", line)
        assert bare is None, f"{line}\nwrite .venv/bin/python -m … or .venv/bin/rover …"


@pytest.mark.parametrize("page", sorted((REPOSITORY / "docs").rglob("*.md")), ids=lambda page: page.name)
def test_every_command_in_a_sentence_names_the_interpreter_in_the_same_way(page: Path) -> None:
    assert not re.findall(r"`(?:python3?|pytest) [^`]*`", page.read_text(encoding="utf-8"))


@pytest.mark.parametrize("block", [b for b in EVERY if b.language == "sh"], ids=lambda block: block.where)
def test_no_block_that_runs_builds_anything(block: Block) -> None:
    builds = re.search(r"^(make|\S*pip) ", block.text, re.MULTILINE)
    assert not builds or block.remark.startswith("not run: "), "it would install a linked checkout into .venv"


@pytest.mark.rig("sitl")
@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_the_shell_blocks_of_a_page_run_as_pasted(page: Path, tmp_path: Path) -> None:
    wanted = list(blocks(page))
    if not any(map(runs, wanted)):
        pytest.skip("no shell block that runs here")
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    folder = checkout(tmp_path)
    for block in wanted:
        if block.remark.startswith("file: "):
            (folder / block.remark.removeprefix("file: ")).write_text(block.text, encoding="utf-8")
        if not runs(block):
            continue
        script = f"set -euo pipefail\n{block.text}"
        try:
            ended = subprocess.run(
                ["bash", "-c", script], cwd=folder, capture_output=True, text=True, timeout=TIME_LIMIT_S, check=False
            )
        except subprocess.TimeoutExpired:
            pytest.fail(f"{block.where} takes longer than {TIME_LIMIT_S} s: mark it <!-- long -->")
        assert ended.returncode == 0, f"{block.where}\n{block.text}\n{ended.stdout}{ended.stderr}"


@pytest.mark.parametrize("block", [b for b in EVERY if b.language == "toml"], ids=lambda block: block.where)
def test_every_toml_block_is_toml(block: Block, tmp_path: Path) -> None:
    file = tmp_path / "block.toml"
    file.write_text(block.text, encoding="utf-8")
    assert read_toml(file)


@pytest.mark.parametrize("block", [b for b in EVERY if b.language == "python"], ids=lambda block: block.where)
def test_every_python_block_runs(block: Block, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", block.text], cwd=checkout(tmp_path), capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, f"{block.where}\n{ended.stderr}"
