"""The simulated world of the rover and the fast half of the emulated RP2040, compiled from src/.

Metres, radians, seconds and volts unless a name says otherwise; pairs are (left, right).
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

class Plant:
    """The rover and its field. The same arguments and calls give the same bytes."""

    def __init__(
        self,
        config_json: str,
        temperature: NDArray[np.float32],
        height: NDArray[np.float32],
        obstacles: NDArray[np.float64],
    ) -> None:
        """`config_json`: keys as in src/config.rs, what is left out is the nominal rover. Rasters (rows, columns) in
        kelvin and metres; obstacles (n, 4): x, y, radius, height. Raises ValueError."""

    @property
    def now_us(self) -> int:
        """Time since the start of the world, µs."""

    def add_layer(self, raster: NDArray[np.float32], series: NDArray[np.float64]) -> None:
        """Lets a part of the ground's temperature change: `raster` (rows, columns) in kelvin times `series` (n,) by
        second since the start, whose last value stays. Raises ValueError."""

    def attach_sitl(self, stdin_fd: int, stdout_fd: int, host_bytes: int = 0) -> None:
        """Puts a firmware process that has just been started into the loop: the write end of its stdin, the read end
        of its stdout, and how many bytes the host had written by then; those on the wire are lost to it.
        Raises OSError."""

    def detach_sitl(self) -> None:
        """Lets go of the firmware, so that it sees the end of its stdin."""

    def record_ticks(self) -> None:
        """Keeps every tick's request and reply from here on, for `take_ticks`."""

    def take_ticks(self) -> bytes:
        """TickRequest and TickReply (protocol/rig_tick.toml) of the ticks since the last call, one after the other;
        empty when they are not recorded."""

    def run_until(self, until_us: int, host_bytes: int) -> list[tuple[int, int]]:
        """Physics and firmware up to `until_us`; `host_bytes`: total that the host has written up to the present.
        Returns (time in µs, total bytes of the firmware) where the total changed. Raises ConnectionError when the
        firmware has ended."""

    def step(self, duty_left: float, duty_right: float, powered: bool) -> None:
        """One millisecond of physics with duties -1 to 1, for rigs that bring their own firmware."""

    def pose(self) -> tuple[float, float, float]:
        """True pose: x, y, heading (unwrapped)."""

    def attitude(self) -> tuple[float, float]:
        """How the rover leans: roll (left side up) and pitch (nose down), radians."""

    def encoders(self) -> tuple[int, int]:
        """x4 quadrature counts."""

    def wheel_angles(self) -> tuple[float, float]:
        """Shaft angles since the start."""

    def wheel_speeds(self) -> tuple[float, float]:
        """Surface speeds, m/s."""

    def slip(self) -> tuple[float, float]:
        """Slip fractions of this moment: ground travel = surface travel × (1 - slip)."""

    def duty(self) -> tuple[float, float, bool]:
        """Duties -1 to 1 and whether the bridges are powered, as commanded last."""

    def battery(self) -> tuple[float, float]:
        """Terminal voltage, and state of charge 0 to 1."""

    def set_charge(self, charge: float) -> None:
        """Sets the state of charge, 0 to 1."""

    def set_emergency_stop(self, active: bool) -> None:
        """Presses or releases the emergency stop."""

    def set_fault(self, name: str, index: int, value: float) -> None:
        """Puts a fault in or, with value 0, takes it away; names and values: src/faults.rs. Raises ValueError."""

    def kick_encoder(self, wheel: int, counts: int) -> None:
        """Makes the encoder of wheel 0 or 1 jump. Raises ValueError for another wheel."""

    def drive_on(self, seen: NDArray[np.bool_], x: float, y: float, heading: float) -> None:
        """Sets the rover where a former run has left it, on ground that was seen then, (rows, columns) as of `seen`.
        Raises ValueError for ground of another area."""

    def carry(self, ahead: float, left: float, turn: float) -> None:
        """Somebody lifts the rover and sets it down elsewhere, as seen from base_link."""

    def add_obstacle(self, x: float, y: float, radius: float, height: float) -> None:
        """An upright disc that was not there before."""

    def signals(self) -> tuple[bool, bool]:
        """Lamp and buzzer."""

    def trigger_sonar(self, sensor: int) -> None:
        """Starts a ranging of sensor 0 to 2; one that still waits for its echo ignores it."""

    def poll_echo(self) -> tuple[int, int] | None:
        """Sensor and length in µs of an echo that is back by now, 0 µs for a timeout; None when none is."""

    def sonar_range(self, sensor: int, x: float, y: float, heading: float) -> float | None:
        """True range of a sonar from a pose, None when nothing is in its cone. Raises ValueError."""

    def take_frames(self) -> list[tuple[int, int, int, bool, bytes]]:
        """Frames delivered since the last call: sequence, exposure and delivery in µs, whether the shutter was
        closed, and the picture as uint16 little-endian, kelvin × 100."""

    def scene(self, x: float, y: float, heading: float) -> NDArray[np.float32]:
        """What a perfect sensor sees from a pose: kelvin, (pixels,), row-major."""

    def truth(self) -> NDArray[np.float64]:
        """True trajectory (n, 4): time, x, y, heading; every 10 ms."""

    def seen(self) -> tuple[NDArray[np.bool_], float, float, float]:
        """Ground seen so far (rows, columns), x and y of its lower-left corner, and the side of a cell."""

    def verdict(self) -> dict[str, float | int | None]:
        """The referee's collisions (harder than 0.1 m/s), bumper_contacts, min_clearance_m, min_wall_clearance_m,
        unseen_ground_m2 and seen_share. A
        clearance is None when there is nothing to keep clear of."""

class Alarm:
    """One alarm of a `Clock`; setting it anew moves it."""

    def schedule(self, nanos: float) -> None:
        """Goes off so many nanoseconds from now, rounded up to whole cycles."""

    def schedule_at(self, cycle: int) -> None:
        """Goes off at that cycle, at once when it has passed."""

    def cancel(self) -> None:
        """Does not go off."""

    @property
    def scheduled(self) -> bool:
        """Whether it is still to go off."""

class Clock:
    """Virtual time of the emulated chip in cycles of 8 ns, as rp2040py's peripherals expect it."""

    def __init__(self) -> None:
        """At cycle 0."""

    @property
    def cycles(self) -> int:
        """Cycles since power-on."""

    @property
    def frequency(self) -> float:
        """Cycles per second."""

    @property
    def nanos(self) -> float:
        """The time in nanoseconds."""

    @property
    def micros(self) -> float:
        """The time in microseconds."""

    @property
    def nanos_to_next_alarm(self) -> float:
        """0 when none is set."""

    @property
    def has_scheduled_alarm(self) -> bool:
        """Whether any alarm is set."""

    def create_alarm(self, callback: Callable[[], object]) -> Alarm:
        """An alarm that is not set yet."""

class Processor:
    """The Cortex-M0+ of one chip with its memory, divider, spinlocks and timer.

    `run_until` may call Python peripherals, and those may call everything here but `run_until` and the registers.
    """

    stopped: bool
    """Set by a peripheral, `run_until` comes out after the instruction."""
    interrupt_nmi_mask: int
    """Interrupts routed to the NMI; stored only, as the firmware routes none."""

    def __init__(self, clock: Clock, rom: bytes, flash: bytearray, sram: bytearray, usb: bytearray) -> None:
        """The arrays are shared and must keep their sizes; flash spans 16 MiB. Raises ValueError."""

    def connect(self, peripherals: dict[int, Any], pins: Any) -> None:
        """`peripherals`: base address to an object with `read_uint32(offset)` and
        `write_uint32_atomic(offset, value, kind)`; `pins`: the SIO's other registers, with `read_uint32(offset)` and
        `write_uint32(offset, value)`."""

    def run_until(self, cycle: int) -> None:
        """Runs up to that cycle, a few cycles further when an instruction crosses it. Raises what a peripheral raises,
        RuntimeError when the processor locks up."""

    def set_interrupt(self, irq: int, value: bool) -> None:
        """Level of an interrupt line."""

    def reset(self) -> None:
        """Starts anew from the boot ROM before the next instruction."""

    def disable_interrupt(self, irq: int) -> None:
        """Takes an interrupt's enable away, as no program would: a fault for tests of the watchdog."""

    def enable_interrupt(self, irq: int) -> None:
        """Gives an interrupt its enable back."""

    @property
    def registers(self) -> list[int]:
        """r0 to r15."""

    @property
    def exception(self) -> int:
        """Number of the exception that is handled; 0 in thread mode."""

    @property
    def timer_targets(self) -> list[int]:
        """What the timer's four alarms are set to, low 32 bits of microseconds."""

    @property
    def instructions(self) -> int:
        """Carried out so far."""

    @property
    def cycles_asleep(self) -> int:
        """Slept through so far."""
