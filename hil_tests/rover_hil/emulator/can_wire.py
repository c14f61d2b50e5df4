"""The CAN wire: slcan's text on the rig's descriptor, a bus, and an MCP2515 on the chip's SPI pins."""

from __future__ import annotations

from rover_hil.emulator import wiring
from rover_hil.emulator.can_bus import CanBus
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.descriptor import Descriptor
from rover_hil.emulator.mcp2515 import Mcp2515
from rover_hil.emulator.paced_adapter import PacedAdapter

BITS_PER_BYTE = 8
# From the beginning of the board's millisecond until the host's frames go on the bus: 60 µs before the tick, so that
# none of them is through before it (the shortest takes 94 µs), and all are long before the next.
RELEASE_US = 134
# 130 µs after the tick: what it says is not through by then (60 µs until it is in the controller, 94 µs on the bus),
# and what the tick before has said is.
HEARD_US = 324


def fit_controller(chip: Chip) -> CanBus:
    """Solders an MCP2515 to SPI0, and gives it a bus that nobody else has joined yet."""
    bus = CanBus(chip.virtual_clock)
    controller = Mcp2515(chip.virtual_clock, bus, wiring.CAN_OSCILLATOR_HZ)
    spi = chip.spi[0]
    answers: list[int] = []
    done = chip.virtual_clock.create_alarm(lambda: spi.complete_transmit(answers.pop()))

    def exchange(byte: int) -> None:
        # The answer is complete when eight clocks have passed.
        answers.append(controller.exchange(byte & 0xFF))
        done.schedule(BITS_PER_BYTE * 1e9 / (spi.clock_frequency or 1e6))

    spi.on_transmit = exchange
    chip.gpio[wiring.CAN_SELECT].add_listener(lambda state, _: controller.select(int(state) == 0))
    controller.on_interrupt = lambda asserted: chip.set_level(wiring.CAN_INTERRUPT, not asserted)
    chip.set_level(wiring.CAN_INTERRUPT, True)
    return bus


class CanWire:
    """The host's adapter on the bus of the board."""

    def __init__(self, chip: Chip, descriptor: int) -> None:
        self._line = Descriptor(descriptor)
        self._adapter = PacedAdapter(fit_controller(chip), chip.virtual_clock)
        self._release = chip.virtual_clock.create_alarm(self._adapter.release)
        self._heard_until = 0

    @property
    def sent(self) -> int:
        """Bytes of text for the host so far."""
        return self._line.sent

    def receive(self, due: int, start: int) -> bool:
        """Takes the host's lines at the beginning of the millisecond; see `Descriptor.read`."""
        data = self._line.read(due)
        if data is not None:
            self._adapter.push(data)
        self._release.schedule_at(start + RELEASE_US * CYCLES_PER_US)
        self._heard_until = start + HEARD_US * CYCLES_PER_US
        return data is not None

    def transmit(self) -> None:
        """Hands on what the adapter has heard of the tick before."""
        self._line.write(self._adapter.hand_over(self._heard_until))
