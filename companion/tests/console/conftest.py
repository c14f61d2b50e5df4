"""One console for the tests of a file."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from companion.tests.console.served import Served, serving


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("runs")) as console:
        yield console
