"""Files as they are after a crash, a bad disk or a bad hand: functions of its bytes and a random generator."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

Damage = Callable[[bytes, Random], bytes]
WORDS = (
    *(b"nan", b"-inf", b"1e999", b"-1", b"0", b"99999999999999999999", b"1e308", b"null", b"true", b'""', b"[]", b"{}"),
    *(b"\x1b[2J", b"\x00", b"\r", b"\xe2\x80\xae", b"\xff\xfe", b'"\\u0000"'),
)


def flipped(content: bytes, random: Random) -> bytes:
    """A few bits."""
    damaged = bytearray(content)
    for _ in range(random.choice((1, 3, 30)) if damaged else 0):
        damaged[random.randrange(len(damaged))] ^= 1 << random.randrange(8)
    return bytes(damaged)


def cut(content: bytes, random: Random) -> bytes:
    return content[: random.randrange(len(content))] if content else content


def zeroed(content: bytes, random: Random) -> bytes:
    """A block that never reached the disk."""
    start = random.randrange(max(len(content), 1))
    end = min(len(content), start + random.choice((16, 512, 4096, 65536)))
    return content[:start] + bytes(end - start) + content[end:]


def swapped(content: bytes, random: Random) -> bytes:
    """A block of it in another place."""
    first, second = sorted(random.randrange(max(len(content), 1)) for _ in range(2))
    size = random.choice((4, 64, 1024))
    return content[:first] + content[second : second + size] + content[first + size :]


def grown(content: bytes, random: Random) -> bytes:
    return content + random.choice((content, random.randbytes(1000), bytes(1_000_000)))


def emptied(_: bytes, __: Random) -> bytes:
    return b""


def noise(content: bytes, random: Random) -> bytes:
    return random.randbytes(max(min(len(content), 100_000), 100))


def reworded(content: bytes, random: Random) -> bytes:
    """One of its numbers or words is another."""
    found = list(re.finditer(rb"-?\d+\.?\d*|\"[^\"\n]*\"|\b[a-z_]+\b", content[:200_000]))
    if not found:
        return flipped(content, random)
    place = random.choice(found)
    return content[: place.start()] + random.choice(WORDS) + content[place.end() :]


DAMAGES: tuple[Damage, ...] = (flipped, flipped, cut, cut, zeroed, swapped, grown, emptied, noise, reworded, reworded)
