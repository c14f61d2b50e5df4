"""Run the RP2040 firmware in the emulated board, talk to it over its UART, and measure what a desktop cannot.

    make firmware && .venv/bin/python firmware/emulate.py

The emulator counts cycles of the Cortex-M0+; its flash answers at once, so the waiting for real flash is not in the
figures.
"""

from __future__ import annotations

import random
from functools import partial
from itertools import pairwise
from pathlib import Path

from rover.link.baud import DEFAULT_BAUD
from rover_hil.emulator import wiring
from rover_hil.emulator.board import TICK_CYCLES, Board
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.elf import flash_segments
from rover_hil.emulator.tick_pipe import Request
from rover_protocol import framing, messages
from rover_protocol.message import Message

ELF = Path(__file__).parent / "build" / "rover-pico.elf"
BYTE_CYCLES = 10 * CYCLES_PER_US * 1_000_000 / DEFAULT_BAUD
BATTERY_MV = 7400
SESSION = 1
ECHO_US = 5800
"""Of something 1 m ahead of each sonar."""

TICK_INTERRUPT, CONTROL_INTERRUPT = 1, 27
CONTROL_HANDLER = 16 + CONTROL_INTERRUPT
LOOK_CYCLES = 25
"""Between two looks at what the processor does: a fifth of a microsecond."""


class Bench:
    """A Pico with released button, full battery, standing wheels and something 1 m ahead of each sonar."""

    def __init__(self) -> None:
        self.chip = Chip()
        self.board = Board(self.chip)
        self.chip.load(flash_segments(ELF))
        self.decoder = framing.Decoder()
        self.last: dict[str, dict[str, int]] = {}
        self.log = bytearray()
        self.sequence = self.counter = 0
        self.stop = False
        self._next_tick = 0
        self.chip.uarts[0].on_sent = self._on_byte

    @property
    def now(self) -> int:
        """Cycles since power-on."""
        return self.chip.virtual_clock.cycles

    @property
    def now_us(self) -> float:
        """The same in microseconds."""
        return self.now / CYCLES_PER_US

    def run_until(self, cycle: int) -> None:
        """Time passes, and the board's surroundings with it, millisecond by millisecond."""
        while self.now < cycle:
            if self.now >= self._next_tick:
                sensor = self.board.take_trigger()
                ping = None if sensor is None else (sensor, ECHO_US)
                now_us = self._next_tick // CYCLES_PER_US
                request = Request(now_us, (0, 0), BATTERY_MV, self.stop, 0, ping)
                self.board.apply(request, self._next_tick)
                self._next_tick += TICK_CYCLES
            self.chip.run_until(min(cycle, self._next_tick))

    def run(self, milliseconds: float) -> None:
        """That much time passes."""
        self.run_until(self.now + round(milliseconds * TICK_CYCLES))

    def live(self, milliseconds: float) -> None:
        """As `run`, with a KeepAlive every 100 ms."""
        while milliseconds > 0:
            self.counter = (self.counter + 1) & 255
            self.send(messages.KeepAlive, counter=self.counter)
            self.run(min(milliseconds, 100))
            milliseconds -= 100

    def send(self, message: Message, **fields: int) -> None:
        """A message, and time to answer."""
        self.run_until(self.post(message, self.now, **fields))
        self.run(2)

    def post(self, message: Message, at: int, **fields: int) -> int:
        """Puts a message on the wire from cycle `at` on, byte by byte at its rate; returns when the last has come."""
        due = float(at)
        for byte in framing.encode(message.ID, self.sequence, message.pack(**fields)):
            due += BYTE_CYCLES
            alarm = self.chip.virtual_clock.create_alarm(partial(self.chip.uarts[0].receive, byte, DEFAULT_BAUD))
            alarm.schedule_at(round(due))
        self.sequence = (self.sequence + 1) & 255
        return round(due)

    def arm(self) -> None:
        """With a new token."""
        token = (self.last["State"]["arm_token"] + 1) & 0xFFFF
        self.send(messages.Arm, token=token, session=SESSION)
        self.live(20)
        assert self.last["State"]["state"] == messages.STATE_ARMED, self.last["State"]

    def busy_share(self, milliseconds: float) -> float:
        """Of the cycles that pass, those in which the processor does not sleep."""
        begin, asleep = self.now, self.chip.processor.cycles_asleep
        self.live(milliseconds)
        return 1.0 - (self.chip.processor.cycles_asleep - asleep) / (self.now - begin)

    def control_rounds(self, count: int) -> list[tuple[float, float]]:
        """Begin and end, in us, of so many rounds of the control loop: a stretch in its interrupt is one.

        The companion talks all the while, at any moment of a round.
        """
        chance = random.Random(2)
        rounds: list[tuple[float, float]] = []
        while self.chip.processor.exception != 0:  # not into the middle of one
            self.run_until(self.now + LOOK_CYCLES)
        while len(rounds) < count:
            if len(rounds) % 4 == 0:
                self.counter = (self.counter + 1) & 255
                self.post(messages.KeepAlive, self.now + round(chance.random() * TICK_CYCLES), counter=self.counter)
            rounds.append(self._control_round())
        return rounds

    def _control_round(self) -> tuple[float, float]:
        while self.chip.processor.exception != CONTROL_HANDLER:
            self.run_until(self.now + LOOK_CYCLES)
        began = self.now_us
        while self.chip.processor.exception != 0:
            self.run_until(self.now + LOOK_CYCLES)
        return began, self.now_us

    def _on_byte(self, byte: int) -> None:
        if self.decoder.push(byte):
            message = messages.BY_ID[self.decoder.identifier]
            payload = bytes(self.decoder.payload[: self.decoder.length])
            fields = message.decode(payload)
            self.last[message.name] = {name: value for name, value in fields.items() if isinstance(value, int)}
            if message is messages.LogText:
                self.log += payload[1:].rstrip(b"\0") + b"\n" * (payload[-1] == 0)


def greet(bench: Bench) -> dict[str, int]:
    """Handshake."""
    bench.send(messages.Hello, schema_hash=messages.SCHEMA_HASH, session=SESSION)
    bench.run(20)
    return bench.last["HelloBuild"]


def busy(bench: Bench) -> None:
    """Share of the processor's time, armed and driving."""
    bench.arm()
    print(f"busy, armed:                    {bench.busy_share(300):.1%}")
    first = bench.last["MotionStatus"]["next_index"]
    bench.send(messages.SegmentStart, index=first, start_time=int(bench.now_us) + 100_000)
    for i, (jerk, flags) in enumerate(((1_500_000, 1), (-1_500_000, 0), (0, 0))):
        bench.send(messages.SegmentTravel, index=first + i, duration=250_000, jerk_travel=jerk)
        bench.send(messages.SegmentHeading, index=first + i, jerk_heading=0, flags=flags)
    bench.live(150)
    share = bench.busy_share(100)
    rounds = bench.control_rounds(240)
    assert bench.last["State"]["state"] == messages.STATE_MOVING, bench.last["State"]
    print(f"busy, driving:                  {share:.1%}")
    # A new round begins after half a millisecond of sleep.
    begins = [b for (_, a), (b, _) in pairwise(rounds) if b - a > 500]
    phases = [begin % 1000 for begin in begins]
    print(f"start of the loop, spread:      {max(phases) - min(phases):.1f} us over {len(phases)} rounds")
    print(f"longest round:                  {max(end - begin for begin, end in rounds):.0f} us")


def emergency_stop(bench: Bench) -> None:
    """From the edge at GP28 to STBY low."""
    chance = random.Random(1)
    delays = []
    for _ in range(20):
        bench.run(50)
        bench.arm()
        bench.run(3 * chance.random())
        ends: list[float] = []
        began = bench.now_us
        bench.chip.gpio[wiring.STANDBY].add_listener(lambda *_, ends=ends: ends.append(bench.now_us))
        bench.stop = True
        bench.chip.set_level(wiring.EMERGENCY_STOP, True)
        bench.run(5)
        delays.append(ends[0] - began)
        bench.stop = False
    print(f"emergency-stop edge to STBY:    {max(delays):.1f} us, worst of {len(delays)}")


def save(bench: Bench) -> None:
    """Set, save, restart, ask."""
    bench.run(50)
    bench.send(messages.ParameterSet, identifier=1, value=400)
    bench.send(messages.ParameterCommand, command=0)
    bench.run(50)
    print(f"save:                           {bench.last['ParameterValue']}")


def watchdog(bench: Bench) -> None:
    """The control loop stops; the watchdog starts the chip again, and the handshake says so."""
    hits: list[float] = []
    restart = bench.chip.watchdog.on_watchdog_trigger

    def bite() -> None:
        hits.append(bench.now_us)
        restart()

    bench.chip.watchdog.on_watchdog_trigger = bite
    began = bench.now_us
    for interrupt in (TICK_INTERRUPT, CONTROL_INTERRUPT):
        bench.chip.processor.disable_interrupt(interrupt)
    bench.run(400)
    cause = messages.VALUES["HelloBuild"]["reset_cause"][greet(bench)["reset_cause"]]
    print(f"control loop dead to reset:     {(hits[0] - began) / 1e3:.0f} ms, reset cause {cause}")
    bench.send(messages.ParameterGet, identifier=1)
    bench.run(20)
    print(f"dead_man after the restart:     {bench.last['ParameterValue']['value']} ms")


def main() -> None:
    """All of it."""
    bench = Bench()
    bench.run(300)
    print(f"handshake:                      {greet(bench)}")
    bench.run(500)
    print(f"log:                            {bench.log.decode().splitlines()}")
    busy(bench)
    bench.send(messages.Stop, reason=1)
    bench.run(600)
    emergency_stop(bench)
    save(bench)
    watchdog(bench)


if __name__ == "__main__":
    main()
