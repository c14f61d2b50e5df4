"""Two texts agree word for word, and number for number within the tolerance."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.results.compare import EXACT, Tolerance, first_difference, read_tolerance


@pytest.mark.parametrize(
    ("written", "printed", "tolerance"),
    [
        ("| a | 1.0 |\n|---|--:|", "| a  | 1.00 |\n\n|-----|-----:|", EXACT),
        ("100 m", "101 m", Tolerance(relative=0.01)),
        ("0.2 K", "0.3 K", Tolerance(absolute=0.1)),
        ("−0.1 K", "-0.1 K", EXACT),
        ("small-3 and 2–5", "small-3 and 2–5", EXACT),
    ],
)
def test_agree(written: str, printed: str, tolerance: Tolerance) -> None:
    assert first_difference(written, printed, tolerance) is None


@pytest.mark.parametrize(
    ("written", "printed", "tolerance", "message"),
    [
        ("100 m", "102 m", Tolerance(relative=0.01), "the page has `100 m`, printed is `102 m`"),
        ("crossing at 17:00", "crossing at 16:48", EXACT, "crossing at 16:48"),
        ("1 K", "-1 K", Tolerance(relative=0.5), "printed is `-1 K`"),
        ("5 mines", "5 stones", Tolerance(relative=1.0), "printed is `5 stones`"),
        ("a\nb", "a", EXACT, "`b`, which is no longer printed"),
        ("a", "a\nb", EXACT, "the page lacks `b`"),
        ("v1.2.3", "v1.2.4", EXACT, "v1.2.4"),
    ],
)
def test_differ(written: str, printed: str, tolerance: Tolerance, message: str) -> None:
    assert message in (first_difference(written, printed, tolerance) or "")


@given(st.text())
def test_every_text_agrees_with_itself(text: str) -> None:
    assert first_difference(text, text) is None


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(0.0, 10.0))
def test_an_absolute_tolerance_is_a_bound_on_the_difference(one: float, other: float, bound: float) -> None:
    agree = first_difference(f"{one:.9f}", f"{other:.9f}", Tolerance(absolute=bound)) is None
    if abs(abs(one - other) - bound) > 1e-6:
        assert agree == (abs(one - other) < bound)


@pytest.mark.parametrize("text", ["", "%", "-1%", "nan", "inf", "two"])
def test_a_tolerance_is_a_share_or_a_number(text: str) -> None:
    with pytest.raises(ValueError, match="a tolerance is a share"):
        read_tolerance(text)
