"""What is wired to which pin; the other side of firmware/pico/src/pins.rs, which a test compares with this."""

from __future__ import annotations

# Pins A and B, left and right.
ENCODERS = ((2, 3), (4, 5))
# Pins IN1 and IN2 of the bridge, left and right.
MOTORS = ((6, 7), (8, 9))
STANDBY = 12
# Pins of trigger and echo in one: left, centre, right.
SONARS = (13, 14, 15)
BUZZER, LED = 22, 25
# High when pressed: a normally closed switch to ground.
EMERGENCY_STOP = 28
# High when a switch is pressed: both are normally closed, in series to ground.
BUMPER = 11
# ADC channel of GP26.
BATTERY_CHANNEL = 0
BATTERY_DIVIDER = 3.0
ADC_REFERENCE_MV = 3300.0
ADC_STEPS = 4096
UART_TX, UART_RX = 0, 1
"""Of UART0. The emulated chip connects its UART and SPI blocks to their wires, not to pins: these and the next three
only document where they are."""
CAN_MISO, CAN_CLOCK, CAN_MOSI = 16, 18, 19
CAN_SELECT, CAN_INTERRUPT = 17, 10
"""Of the MCP2515 on SPI0."""
INERTIAL_DATA, INERTIAL_CLOCK = 20, 21
"""Of I2C0, likewise."""
# The crystal on the module.
CAN_OSCILLATOR_HZ = 8_000_000
