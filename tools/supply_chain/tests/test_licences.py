"""What may be used, and what is objected to, by name."""

from __future__ import annotations

from pathlib import Path

import pytest
from license_expression import ExpressionError

from tools.supply_chain.component import Component
from tools.supply_chain.licences import allowed, can_be_asked, may_be_used, objections
from tools.supply_chain.python_packages import locks, packages

ROOT = Path(__file__).parents[3]
NAMES = allowed(ROOT)
NOTICE = (ROOT / "NOTICE").read_text()


@pytest.mark.parametrize(
    ("expression", "right"),
    [
        ("MIT", True),
        ("GPL-3.0-only OR MIT", True),
        ("GPL-3.0-only AND MIT", False),
        ("(GPL-3.0-only OR Apache-2.0) AND Unicode-3.0", True),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("GPL-2.0-only WITH Classpath-exception-2.0", False),
        ("AGPL-3.0-or-later", False),
    ],
)
def test_one_side_of_a_choice_has_to_be_allowed_and_both_of_a_sum(expression: str, right: bool) -> None:
    assert may_be_used(expression, NAMES) is right


@pytest.mark.parametrize("expression", ["mostly harmless", "MIT AND", "BSD"])
def test_what_is_not_spdx_is_not_taken_for_a_licence(expression: str) -> None:
    with pytest.raises(ExpressionError):
        may_be_used(expression, NAMES)


@pytest.mark.parametrize(
    ("name", "licence", "words"),
    [
        ("a", "GPL-3.0-only", "GPL-3.0-only is not among"),
        ("a", "", "tells no licence"),
        ("python-can", "GPL-3.0-only", "is not among"),  # it may not change under an exception
        ("a", "LGPL-3.0-only", "is not among"),
    ],
)
def test_an_objection_names_package_and_licence(name: str, licence: str, words: str) -> None:
    (line,) = objections([Component("pypi", name, "1.0", licence)], NAMES, NOTICE)
    assert f"{name} 1.0 (pypi)" in line
    assert words in line


def test_what_is_noted_has_to_stand_in_the_notice() -> None:
    can = Component("pypi", "python-can", "4.0", "LGPL-3.0-only")
    assert objections([can], NAMES, NOTICE) == []
    (line,) = objections([can], NAMES, "")
    assert "NOTICE" in line


def test_every_package_that_a_rover_runs_on_tells_a_licence_that_is_allowed() -> None:
    found = packages(ROOT, "run")
    assert {"numpy", "python-can", "sympy"} <= {each.name for each in found}
    assert all(each.licence and each.sha256 for each in found)
    assert objections(found, NAMES, NOTICE) == []


def test_of_an_extra_what_is_installed_is_looked_at() -> None:
    assert "dev" not in locks(ROOT)
    assert not can_be_asked(Component("pypi", "nobody-has-this-installed", "1.0", ""))
    assert can_be_asked(Component("pypi", "numpy", "1.0", ""))
