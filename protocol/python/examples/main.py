"""node.py on a board: a UART to the companion and an HC-SR04 on two pins. Copy it as main.py, see README.md."""

import time

from machine import UART, Pin
from node import Node

UART_NUMBER, BAUD = 0, 230_400
TRIGGER, ECHO, LED = 10, 11, 25
PING_MS = 60
# 4.3 m there and back.
ECHO_TIMEOUT_US = 25_000


class Clock:
    """µs since the start, 32 bits: ticks_us wraps earlier, so it has to be read at least every few minutes."""

    def __init__(self):
        self._ticks = time.ticks_us()
        self._time = 0

    def now(self):
        ticks = time.ticks_us()
        self._time = (self._time + time.ticks_diff(ticks, self._ticks)) & 0xFFFFFFFF
        self._ticks = ticks
        return self._time


class Ultrasonic:
    """An HC-SR04, timed by interrupts, so that the line is served while an echo is under way."""

    def __init__(self, trigger, echo):
        self._trigger = Pin(trigger, Pin.OUT, value=0)
        self._echo = Pin(echo, Pin.IN)
        self._rose = self._fell = None
        self._echo.irq(self._edge, Pin.IRQ_RISING | Pin.IRQ_FALLING)

    def ping(self):
        """Starts a ranging."""
        self._rose = self._fell = None
        self._trigger.value(1)
        time.sleep_us(10)
        self._trigger.value(0)

    def echo_us(self):
        """How long the echo pin was high; 0 when too long for an echo, -1 when it never rose."""
        if self._rose is None:
            return -1
        if self._fell is None:
            return 0
        width = time.ticks_diff(self._fell, self._rose)
        return width if width < ECHO_TIMEOUT_US else 0

    def _edge(self, pin):
        if pin.value():
            self._rose = time.ticks_us()
        elif self._rose is not None:
            self._fell = time.ticks_us()


def main():
    uart = UART(UART_NUMBER, BAUD, rxbuf=512)
    led = Pin(LED, Pin.OUT)
    clock = Clock()
    node = Node(lambda buffer, length: uart.write(memoryview(buffer)[:length]), clock.now)
    sonar = Ultrasonic(TRIGGER, ECHO)
    pinged, pinged_at = time.ticks_ms(), clock.now()
    sonar.ping()
    while True:
        if uart.any():
            node.receive(uart.read(uart.any()))
        node.tick()
        led.value(node.companion_is_there())
        if time.ticks_diff(time.ticks_ms(), pinged) >= PING_MS:
            node.ranged(sonar.echo_us(), pinged_at)
            pinged, pinged_at = time.ticks_ms(), clock.now()
            sonar.ping()


main()
