"""`rover jog`: the wheels by hand."""

from __future__ import annotations

import math
import os
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.connection import Baud, Port, connected
from rover.cli.output import say
from rover.errors import BadInput
from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.link.jogging import Jog, Wish
    from rover.link.session import Link

HELP = """Drive by hand, with the keys of this terminal: for the bench, and to get a rover out of somewhere.

Arrow keys drive and turn; q and a turn the left wheel forward and back, e and d the right one. The rover moves while a
key is held and brakes when it is let go; the space bar brakes at once, x is an emergency stop, Esc or Ctrl-C ends. The
motors are off until the first key, and at the end. The firmware's stops hold as always: guard, dead-man, bumper,
emergency stop. Somebody has to see the rover.

\b
Examples:
  rover jog --port /dev/ttyACM0
  rover jog --port /dev/ttyACM0 --speed 0.05      gently, wheels in the air or not
"""
ARROWS = {"\x1b[A": "up", "\x1b[B": "down", "\x1b[C": "right", "\x1b[D": "left"}
ESCAPE = "\x1b"
SHOWN_S = 0.2


def command(
    port: Port,
    speed: Annotated[float, typer.Option(min=0.01, max=0.15, metavar="M/S", help="While a key is held.")] = 0.1,
    turning: Annotated[float, typer.Option(min=0.05, max=0.6, metavar="RAD/S", help="The same for turning.")] = 0.5,
    track: Annotated[
        float, typer.Option(min=0.05, max=1.0, metavar="M", help="Between the wheels, for single ones.")
    ] = 0.2,
    baud: Baud = DEFAULT_BAUD,
) -> int:
    """See HELP."""
    if not sys.stdin.isatty():
        raise BadInput("jog: the keys of a terminal are needed; stdin is none")
    from rover.link.jogging import Jog
    from rover.link.watching import Moment, with_event

    wishes = _wishes(speed, turning, track)
    with connected(port, baud) as link:
        jog, moment, shown = Jog(link), Moment(0.0), -math.inf
        say("arrows drive, q a left wheel, e d right wheel, space brakes, x emergency stop, Esc ends")
        try:
            with _keys() as keys:
                while True:
                    for key in keys():
                        if key == ESCAPE:
                            return _end(link, jog)
                        if key == "x":
                            link.emergency_stop()
                        elif key in wishes:
                            jog.ask(wishes[key])
                        else:
                            jog.release()
                    for event in link.poll():
                        moment = with_event(moment, event)
                    jog.step()
                    if time.monotonic() - shown > SHOWN_S:
                        shown = time.monotonic()
                        _show(moment.rows())
                    link.clock.advance(link.clock.now() + 0.02)
        except KeyboardInterrupt:
            return _end(link, jog)


def _wishes(speed: float, turning: float, track: float) -> dict[str, Wish]:
    from rover.link.jogging import Wish

    single = 0.5 * speed, speed / track
    if single[1] > turning:
        single = 0.5 * turning * track, turning
    travel, heading = single
    return {
        "up": Wish(speed, 0.0),
        "down": Wish(-speed, 0.0),
        "left": Wish(0.0, turning),
        "right": Wish(0.0, -turning),
        "q": Wish(travel, -heading),
        "a": Wish(-travel, heading),
        "e": Wish(travel, heading),
        "d": Wish(-travel, -heading),
    }


def _end(link: Link, jog: Jog) -> int:
    """Brakes, and switches the motors off."""
    jog.release()
    link.disarm()
    say("ended: the motors are off")
    return 0


def _show(rows: list[tuple[str, str]]) -> None:
    """One line that is written over the last, cut off at the terminal's edge."""
    if not sys.stderr.isatty():
        return
    told = dict(rows)
    line = "  ".join(f"{name} {told[name]}" for name in ("state", "speed", "counts", "ranges", "battery"))
    sys.stderr.write(f"\r\x1b[K{line[: os.get_terminal_size(sys.stderr.fileno()).columns - 1]}")
    sys.stderr.flush()


@contextmanager
def _keys() -> Iterator[Keys]:
    """The terminal without waiting for lines while the block runs; yields what has been typed since the last call."""
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield Keys(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
        sys.stderr.write("\n")


class Keys:
    """Keys by name: up, down, left, right, Esc, or the letter. A terminal that is gone counts as Esc."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def __call__(self) -> list[str]:
        if not select.select([self._descriptor], [], [], 0.0)[0]:
            return []
        try:
            typed = os.read(self._descriptor, 256).decode("utf-8", errors="replace")
        except OSError:
            typed = ""
        return split_keys(typed) if typed else [ESCAPE]


def split_keys(typed: str) -> list[str]:
    """What has been typed, key by key."""
    found = []
    while typed:
        arrow = next((code for code in ARROWS if typed.startswith(code)), None)
        found.append(ARROWS[arrow] if arrow else typed[0])
        typed = typed[len(arrow) if arrow else 1 :]
    return found
