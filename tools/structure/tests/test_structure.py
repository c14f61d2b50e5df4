"""What counts as an import, as a cycle and as a module that nobody needs."""

from __future__ import annotations

from pathlib import Path

from tools.structure import python_imports, rust_uses


def test_a_file_is_a_module_below_the_folder_that_it_is_imported_from() -> None:
    files = ["companion/src/rover/link/port.py", "companion/src/rover/link/__init__.py", "hil_tests/rover_hil/rig.py",
             "tools/flash/uf2.py", "hil_tests/tests/test_device.py", "docs/examples/talk.py"]  # fmt: skip
    assert set(python_imports.modules_of(map(Path, files))) == {
        "rover.link.port", "rover.link", "rover_hil.rig", "tools.flash.uf2",
    }  # fmt: skip


def test_imports_within_functions_and_for_types_count() -> None:
    known = dict.fromkeys(("a", "a.b", "a.c", "a.d"), Path())
    source = """
from typing import TYPE_CHECKING
import a.b
if TYPE_CHECKING:
    from a.c import C
def f():
    from a import d, something_in_its_init
"""
    assert python_imports.imports_of(source, "main", known) == {"a", "a.b", "a.c", "a.d"}


def test_a_cycle_is_a_group_that_reaches_itself() -> None:
    graph = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set(), "e": {"d"}}
    assert python_imports.cycles(graph) == [["a", "b", "c"]]
    assert python_imports.cycles({"a": {"b"}, "b": set()}) == []


def test_what_no_entry_leads_to_is_unreached() -> None:
    assert python_imports.unreached({"a": {"b"}, "b": set(), "c": {"b"}}, ["a"]) == ["c"]


def test_rust_paths_count_outside_of_comments_and_tests() -> None:
    modules = rust_uses.modules_of(map(Path, ("lib.rs", "link.rs", "link/frame.rs", "clock.rs", "motion/mod.rs")))
    assert set(modules) == {"crate", "crate::link", "crate::link::frame", "crate::clock", "crate::motion"}
    source = """
use crate::clock::Clock; // not crate::motion
use super::link::frame::{Frame, self};
#[cfg(test)]
mod tests {
    use crate::motion::Motion;
}
"""
    assert rust_uses.uses_of(source, "crate::uart", modules) == {"crate::clock", "crate::link::frame"}
    grouped = "use crate::{clock::Clock, link::{frame, Link}, motion as moving};"
    assert rust_uses.uses_of(grouped, "crate::uart", modules) == {
        "crate::clock", "crate::link", "crate::link::frame", "crate::motion",
    }  # fmt: skip
