"""Counters that wrap on the wire, made whole again."""

from __future__ import annotations


def unwrap(raw: int, bits: int, near: int) -> int:
    """The integer congruent to `raw` modulo 2**bits that lies nearest to `near`.

    >>> unwrap(3, 8, 254)
    259
    """
    span = 1 << bits
    return near + (raw - near + span // 2) % span - span // 2


def ahead(index: int, reference: int, bits: int = 16) -> int:
    """How far `index` lies ahead of `reference` on a wrapping counter; negative when behind."""
    return unwrap(index, bits, reference) - reference
