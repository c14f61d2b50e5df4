"""The judge of the campaign: what it must object to, and damage that really is some."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from tools.chaos.damage import DAMAGES, Damage
from tools.chaos.process import Ended, run, start
from tools.chaos.verdict import complaints, missing


def ended(code: int | None = 2, out: str = "", err: str = "rover: it: no such file\n", memory: float = 100.0) -> Ended:
    return Ended(("rover",), code, out, err, 1.0, memory)


def test_one_line_is_all_right() -> None:
    assert complaints(ended(), 10.0, 300.0) == []
    assert complaints(ended(0, "found\n", ""), 10.0, 300.0) == []


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (ended(1, "", "rover: unexpected error: KeyError: 'x'\n"), "unexpected error"),
        (ended(None), "had not ended after 10 s"),
        (ended(-11), "exit code -11"),
        (ended(4), "exit code 4"),
        (ended(err='Traceback (most recent call last):\n  File "x"\n'), "traceback"),
        (ended(memory=2_000.0), "2000 MB of memory"),
        (ended(err="rover: \x1b[31mred: no such file\n"), "U+001B"),
        (ended(err="libpng error: bad\nrover: cut\n"), "not its own: libpng error"),
        (ended(err="rover: first\nrover: second\n"), "2 lines instead of one"),
        (ended(err=""), "0 lines instead of one"),
    ],
)
def test_what_must_not_be_is_named(how: Ended, words: str) -> None:
    assert any(words in complaint for complaint in complaints(how, 10.0, 300.0, (0, 2)))


def test_what_a_run_should_have_left_is_missed(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("{}")
    assert missing(tmp_path) == ["report.html is missing"]


def test_a_command_is_ended_at_its_limit_and_its_memory_is_told() -> None:
    done = run("--version", limit_s=120.0)
    assert (done.code, done.out[:6]) == (0, "rover ")
    assert 5.0 < done.memory_mb < 300.0
    assert start("doctor").end(0.0).code is None


@pytest.mark.parametrize("damage", sorted({each.__name__: each for each in DAMAGES}.items()))
def test_damage_changes_a_file_and_is_the_same_for_one_seed(damage: tuple[str, Damage]) -> None:
    right = b'[mission]\nname = "field"\nwidth_m = 2.5\n' * 40
    _, change = damage
    made = [change(right, Random(seed)) for seed in range(20)]
    assert made == [change(right, Random(seed)) for seed in range(20)]
    assert sum(each != right for each in made) >= 15
    assert isinstance(change(b"", Random(1)), bytes)
