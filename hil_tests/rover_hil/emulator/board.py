"""The rover's electronics around the chip: encoders, bridge, sonars, battery, panel and emergency stop as pins."""

from __future__ import annotations

from collections.abc import Callable

from rover_hil.emulator import wiring
from rover_hil.emulator.chip import CYCLES_PER_US, Chip
from rover_hil.emulator.lsm6dso import Lsm6dso
from rover_hil.emulator.quadrature import edges
from rover_hil.emulator.tick_pipe import Request

TICK_CYCLES = 1000 * CYCLES_PER_US
# The board's millisecond begins and ends so long after a tick of its control loop: by then the tick's outputs are out,
# and what has happened in the world's millisecond comes in time for the next one.
PHASE_US = 806
# In which the encoders turn by what they have turned in a millisecond, well before the tick.
EDGES_US = 150
BURST_US, LATE_BURST_US = 650, 350
"""From the trigger until the echo pin of an HC-SR04 rises, and what it may take longer, as in the plant."""
BEFORE_TICK_US, AFTER_TICK_US = 40, 300
"""An echo that ended so near to a tick would be heard in this one or in the next, as it happens."""
# How long the echo pin stays high when nothing comes back.
SILENCE_US = 38_000


def burst_us(echo_us: int) -> int:
    """Length of the burst before an echo, such that the echo does not end while the firmware looks for it; the same
    rule as in hil_tests/plant/src/sonar.rs."""
    end = (PHASE_US + BURST_US + echo_us) % 1000
    return BURST_US if AFTER_TICK_US <= end < 1000 - BEFORE_TICK_US else BURST_US + LATE_BURST_US


class Board:
    """Drives the chip's inputs from what the plant says, and reads its outputs back."""

    def __init__(self, chip: Chip) -> None:
        self.chip = chip
        self._counts: tuple[int, int] | None = None
        self._triggered: int | None = None
        # A switched-on board: encoders and echoes low, the switch closed.
        low = [pin for pair in wiring.ENCODERS for pin in pair] + list(wiring.SONARS)
        for pin in (*low, wiring.EMERGENCY_STOP, wiring.BUMPER):
            chip.set_level(pin, False)
        for sensor, pin in enumerate(wiring.SONARS):
            chip.gpio[pin].add_listener(self._trigger_listener(sensor))
        self.inertial = Lsm6dso()
        chip.i2c0.target = self.inertial

    def apply(self, request: Request, start: int) -> None:
        """Sets the inputs of the millisecond that begins at cycle `start`."""
        self.set_levels(request)
        before = self._counts or request.counts
        for wheel, pins in enumerate(wiring.ENCODERS):
            for cycle, a, b in edges(before[wheel], request.counts[wheel], start, start + EDGES_US * CYCLES_PER_US):
                self._at(cycle, self._encoder_edge(pins, a, b))
        self._counts = request.counts
        if request.ping is not None:
            sensor, echo_us = request.ping
            rise = start + (burst_us(echo_us) if echo_us else BURST_US) * CYCLES_PER_US
            echo = wiring.SONARS[sensor]
            self._at(rise, lambda: self.chip.set_level(echo, True))
            self._at(rise + (echo_us or SILENCE_US) * CYCLES_PER_US, lambda: self.chip.set_level(echo, False))

    def set_levels(self, request: Request) -> None:
        """Sets what keeps its level: battery, emergency stop, bumper, and the inertial sensor's registers."""
        chip = self.chip
        self.inertial.present = request.inertial == 1
        self.inertial.holds_bus = request.inertial == 2
        if request.inertial:
            self.inertial.show((request.temperature, *request.gyro, *request.acceleration))
        millivolts = request.battery_mv / wiring.BATTERY_DIVIDER
        steps = int(millivolts / wiring.ADC_REFERENCE_MV * wiring.ADC_STEPS)
        chip.adc.channel_values[wiring.BATTERY_CHANNEL] = min(wiring.ADC_STEPS - 1, steps)
        switches = ((wiring.EMERGENCY_STOP, request.emergency_stop), (wiring.BUMPER, request.bumper))
        for pin, pressed in switches:
            if bool(chip.gpio_values >> pin & 1) != pressed:
                chip.set_level(pin, pressed)

    def take_trigger(self) -> int | None:
        """Sensor whose trigger pin was pulsed since the last call; the line's fall starts the burst."""
        sensor, self._triggered = self._triggered, None
        return sensor

    @property
    def duty(self) -> tuple[float, float]:
        """Mean voltage over each motor by the battery's, -1 to 1: the difference of the bridge's two inputs."""
        level = self.chip.pwm_slices.level
        left, right = (level(in1) - level(in2) for in1, in2 in wiring.MOTORS)
        return left, right

    def output(self, pin: int) -> bool:
        """Whether the chip drives `pin` high."""
        sio = self.chip.sio
        return bool(sio.gpio_value & sio.gpio_output_enable & 1 << pin)

    def _at(self, cycle: int, action: Callable[[], None]) -> None:
        self.chip.virtual_clock.create_alarm(action).schedule_at(cycle)

    def _encoder_edge(self, pins: tuple[int, int], a: bool, b: bool) -> Callable[[], None]:
        def change() -> None:
            for pin, level in zip(pins, (a, b), strict=True):
                if bool(self.chip.gpio_values >> pin & 1) != level:
                    self.chip.set_level(pin, level)

        return change

    def _trigger_listener(self, sensor: int) -> Callable[[int, int], None]:
        def on_change(state: int, before: int) -> None:
            # The fall of a pulse; a pin that is driven low or let go of was not high before.
            if state == 0 and before == 1:
                self._triggered = sensor

        return on_change
