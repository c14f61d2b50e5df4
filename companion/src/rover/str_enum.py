"""The standard library's `StrEnum`, on Python 3.10 too: members are the words that files and screens show."""

from __future__ import annotations

import sys

if sys.version_info >= (3, 11):
    from enum import StrEnum as StrEnum
else:
    from enum import Enum

    class StrEnum(str, Enum):
        """A string among a fixed few; formats as its value."""

        __str__ = str.__str__
