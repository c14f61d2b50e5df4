"""The one reader of TOML tables: what it hands out, and the one line in which it refuses."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rover.errors import BadInput
from rover.toml_file import read_toml
from rover.toml_table import Table

FILE = Path("some.toml")


def table(**values: object) -> Table:
    return Table(FILE, values, "part")


def test_values_are_taken_as_they_stand_and_numbers_as_floats() -> None:
    t = table(a=3, b=2.5, c="x", d=True, e=[[1, 2], [3, 4]], f=["x", "y"], g="6:30")
    assert (t.number("a", 0, 9), t.number("b", 0, 9), t.integer("a", 0, 9)) == (3.0, 2.5, 3)
    assert (t.text("c"), t.choice("c", ("x", "y")), t.flag("d")) == ("x", "x", True)
    assert (t.rows("e", ("p", "q"), 0, 9), t.choices("f", ("x", "y"))) == (((1.0, 2.0), (3.0, 4.0)), ("x", "y"))
    assert t.clock_time("g") == 6.5 * 3600.0


def test_what_is_absent_is_the_default() -> None:
    t = table()
    assert (t.number("a", 0, 9, 4.0), t.integer("a", 0, 9, 4)) == (4.0, 4)
    assert (t.text("a", ""), t.flag("a", False)) == ("", False)
    assert (t.numbers("a", 0, 9, (1.0,)), t.rows("a", ("x", "y"), 0, 9), t.tables("a")) == ((1.0,), (), [])
    assert t.table("a").names() == []


@pytest.mark.parametrize(
    ("values", "read", "says"),
    [
        ({}, lambda t: t.number("side_m", 0, 9), "[part] side_m: missing"),
        ({"side_m": "3"}, lambda t: t.number("side_m", 0, 9), "[part] side_m: must be a number in m, not '3'"),
        ({"v_m_s": 12}, lambda t: t.number("v_m_s", 0, 9), "[part] v_m_s: 12 lies outside 0 to 9 m/s"),
        ({"a_m_s2": -1}, lambda t: t.number("a_m_s2", 0, 9), "[part] a_m_s2: -1 lies outside 0 to 9 m/s²"),
        ({"n": 1.0}, lambda t: t.integer("n", 0, 9), "[part] n: must be a whole number, not 1.0"),
        ({"n": True}, lambda t: t.integer("n", 0, 9), "[part] n: must be a whole number, not True"),
        ({"s": ""}, lambda t: t.text("s"), "[part] s: must not be blank"),
        ({"s": "snad"}, lambda t: t.choice("s", ("sand", "clay")), "[part] s: 'snad' is not one of sand, clay; d"),
        ({"p": [1]}, lambda t: t.row("p", ("x", "y"), 0, 9), "[part] p: must be [x, y], not [1]"),
        ({"p": [[1, 2], [1, 99]]}, lambda t: t.rows("p", ("x", "y"), 0, 9), "[part] p entry 2: 99 lies"),
        ({"w": []}, lambda t: t.choices("w", ("a",)), "[part] w: must name at least one"),
        ({"t": 3}, lambda t: t.table("t"), "[part.t] must be a table"),
        ({"t": [{}, 3]}, lambda t: t.tables("t"), "[part.t 2] must be a table"),
        ({"colour": 1}, lambda t: t.only("color"), "[part] colour: unknown key; did you mean color?"),
        ({"side_cm": 1}, lambda t: t.only("side_m"), "[part] side_cm: unknown key; wrong unit? it is side_m here"),
        ({"zzz": 1}, lambda t: t.only("a", "b"), "[part] zzz: unknown key; known are a, b"),
        ({"n": 16**5000}, lambda t: t.integer("n", 0, 9), "[part] n: a huge number lies outside 0 to 9"),
    ],
)
def test_what_is_wrong_is_one_line_with_table_and_key(
    values: dict[str, object], read: Callable[[Table], Any], says: str
) -> None:
    with pytest.raises(BadInput) as caught:
        read(table(**values))
    assert str(caught.value).startswith(f"some.toml: {says}")


def test_the_file_itself_has_no_header_in_front_of_its_keys() -> None:
    with pytest.raises(BadInput, match=r"^some\.toml: width: missing$"):
        Table(FILE, {}, "").number("width", 0, 9)


@given(st.text(min_size=1), st.text())
def test_whatever_stands_in_a_file_is_told_on_one_line(key: str, value: str) -> None:
    for read in (lambda t: t.only("known"), lambda t: t.number(key, 0, 9), lambda t: t.choice(key, ("a", "b"))):
        with pytest.raises(BadInput) as caught:
            read(Table(FILE, {key: "." + value}, "part"))
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (".".join(["a"] * 50_000) + " = 1\n", "a key of over 32 parts"),
        ("[" + " . ".join(['"a b"'] * 5_000) + "]\n", "a key of over 32 parts"),
        ("a = 1\n" + "#" * 1_100_000, "over 1 MB"),
        ("a" * 1_000_000, "not valid TOML"),
    ],
    ids=["dotted", "quoted, of a table", "large", "one word"],
)
def test_what_would_cost_more_than_it_can_be_worth_is_refused_at_once(tmp_path: Path, content: str, part: str) -> None:
    file = tmp_path / "hostile.toml"
    file.write_text(content)
    begin = time.process_time()
    with pytest.raises(BadInput, match=part):
        read_toml(file)
    assert time.process_time() - begin < 10.0


def test_long_rows_of_numbers_are_no_long_keys(tmp_path: Path) -> None:
    file = tmp_path / "mission.toml"
    file.write_text("a.b.c = [" + ", ".join(["1.25"] * 500) + "]\nname = '" + "v1.2." * 6 + "'\n")
    assert len(read_toml(file)["a"]["b"]["c"]) == 500
