"""Blocks are found, filled and left alone as the markers say."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tools.results.compare import EXACT, Tolerance
from tools.results.page import Block, PageError, blocks, filled

PAGE = """# Results

<!-- results cheap tolerance=2%: rover one -->

| a |

<!-- /results -->

between

<!-- results text: rover two | tail -n 1 -->
<!-- /results -->
end
"""


def test_blocks_come_with_their_command_and_options() -> None:
    one, two = blocks(PAGE)
    assert one == Block(3, "rover one", True, False, Tolerance(relative=0.02), "\n| a |\n\n")
    assert two == Block(11, "rover two | tail -n 1", False, True, EXACT, "")


def test_a_filled_page_holds_what_was_printed_and_can_be_filled_again() -> None:
    new = filled(PAGE, lambda block: f"printed by {block.command}  \n")
    assert "-->\n\nprinted by rover one\n\n<!-- /results -->" in new
    assert "-->\n\n```text\nprinted by rover two | tail -n 1\n```\n\n<!-- /results -->" in new
    assert filled(new, lambda block: f"printed by {block.command}") == new


def test_a_block_without_output_stays_as_it_is() -> None:
    assert filled(PAGE, lambda block: None) == PAGE


def test_markers_in_a_fenced_block_are_an_example() -> None:
    assert blocks(f"```markdown\n{PAGE}```\n") == []


@given(st.lists(st.text(alphabet="ab|`\n ~-<>", max_size=20), max_size=5))
def test_text_around_blocks_is_kept(texts: list[str]) -> None:
    page = "\n<!-- results: x -->\n<!-- /results -->\n".join(texts)
    assert filled(page, lambda block: None) == page


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a\n<!-- results: x -->\n", "line 2: the block has no"),
        ("<!-- results: x -->\n<!-- results: y -->\n<!-- /results -->", "line 2: a block begins before the one of"),
        ("<!-- results quick: x -->\n<!-- /results -->", "line 1: `quick` is none of"),
        ("<!-- results tolerance=lots: x -->\n<!-- /results -->", "line 1: a tolerance is a share"),
        ("<!-- results cheap: -->\n<!-- /results -->", "line 1: the block has no command"),
    ],
)
def test_a_marker_that_cannot_be_read_is_named_with_its_line(text: str, message: str) -> None:
    with pytest.raises(PageError, match=message):
        blocks(text)
