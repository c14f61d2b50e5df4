"""One millisecond between a simulated rig and its firmware, as bytes on a pair of pipes.

Written by `python -m tools.generate`: change protocol/rig_tick.toml, not this file.
"""

import struct

# `echo_sensor` and `sonar_trigger` when there is none.
NO_SENSOR = 255
# `host_bytes_due` of a rig that does not count: takes whatever is there.
ALL_HOST_BYTES = 18446744073709551615
# Bit of `flags`: the bridges are on.
POWERED = 1
# Bit of `flags`: the lamp is lit.
LED = 2
# Bit of `flags`: the buzzer sounds.
BUZZER = 4


class TickRequest:
    """What the firmware's peripherals read at a tick.

    now_us: Time since the firmware's start, µs.
    encoder_left: Quadrature counts, x4, forward positive, wrapping.
    encoder_right: As for the left wheel.
    echo_us: Length of the echo that has ended by now, µs; 0 for a timeout.
    battery_mv: Battery at its terminals, mV.
    echo_sensor: Sonar that the echo belongs to; NO_SENSOR: none has ended.
    emergency_stop: 1 while the emergency-stop input is active.
    host_bytes_due: Bytes of the host that must have come before this tick, in total.
    ping: 1 + the sonar that was triggered in the last tick; 0: none was.
    bumper: 1 while a switch of the bumper is pressed.
    inertial: 1 while there is an inertial sensor that answers, 2 while it holds the bus.
    ping_echo_us: Length of the echo that it is going to hear, µs; 0: none.
    gyro_x: Rate about base_link's x as the sensor has it in its registers: 8.75 mdeg/s.
    gyro_y: As for x.
    gyro_z: As for x.
    acceleration_x: What it feels along base_link's x, likewise: 0.061 mg.
    acceleration_y: As for x.
    acceleration_z: As for x.
    temperature: Of the sensor, likewise: 1/256 K from 25 degrees Celsius.
    """

    SIZE = 56
    FORMAT = "<QiiIHBBQBBB1xIhhhhhhh2x"

    def __init__(
        self,
        now_us: int = 0,
        encoder_left: int = 0,
        encoder_right: int = 0,
        echo_us: int = 0,
        battery_mv: int = 0,
        echo_sensor: int = 255,
        emergency_stop: int = 0,
        host_bytes_due: int = 0,
        ping: int = 0,
        bumper: int = 0,
        inertial: int = 0,
        ping_echo_us: int = 0,
        gyro_x: int = 0,
        gyro_y: int = 0,
        gyro_z: int = 0,
        acceleration_x: int = 0,
        acceleration_y: int = 0,
        acceleration_z: int = 0,
        temperature: int = 0,
    ) -> None:
        self.now_us = now_us
        self.encoder_left = encoder_left
        self.encoder_right = encoder_right
        self.echo_us = echo_us
        self.battery_mv = battery_mv
        self.echo_sensor = echo_sensor
        self.emergency_stop = emergency_stop
        self.host_bytes_due = host_bytes_due
        self.ping = ping
        self.bumper = bumper
        self.inertial = inertial
        self.ping_echo_us = ping_echo_us
        self.gyro_x = gyro_x
        self.gyro_y = gyro_y
        self.gyro_z = gyro_z
        self.acceleration_x = acceleration_x
        self.acceleration_y = acceleration_y
        self.acceleration_z = acceleration_z
        self.temperature = temperature

    def pack(self) -> bytes:
        """The 56 bytes."""
        return struct.pack(
            self.FORMAT,
            self.now_us,
            self.encoder_left,
            self.encoder_right,
            self.echo_us,
            self.battery_mv,
            self.echo_sensor,
            self.emergency_stop,
            self.host_bytes_due,
            self.ping,
            self.bumper,
            self.inertial,
            self.ping_echo_us,
            self.gyro_x,
            self.gyro_y,
            self.gyro_z,
            self.acceleration_x,
            self.acceleration_y,
            self.acceleration_z,
            self.temperature,
        )

    @classmethod
    def unpack(cls, data: bytes) -> "TickRequest":
        """From 56 bytes. Raises struct.error when there are more or fewer."""
        return cls(*struct.unpack(cls.FORMAT, data))


class TickReply:
    """What the firmware's peripherals do until the next tick.

    duty_left: Q15 as the bridge makes it: 32767 is full duty forward.
    duty_right: As for the left motor.
    flags: POWERED, LED, BUZZER.
    sonar_trigger: Sonar to ping now: 0 left, 1 centre, 2 right; or NO_SENSOR.
    bytes_sent: Bytes that the firmware has sent to the host, in total.
    """

    SIZE = 16
    FORMAT = "<hhBB2xQ"

    def __init__(
        self,
        duty_left: int = 0,
        duty_right: int = 0,
        flags: int = 0,
        sonar_trigger: int = 255,
        bytes_sent: int = 0,
    ) -> None:
        self.duty_left = duty_left
        self.duty_right = duty_right
        self.flags = flags
        self.sonar_trigger = sonar_trigger
        self.bytes_sent = bytes_sent

    def pack(self) -> bytes:
        """The 16 bytes."""
        return struct.pack(
            self.FORMAT,
            self.duty_left,
            self.duty_right,
            self.flags,
            self.sonar_trigger,
            self.bytes_sent,
        )

    @classmethod
    def unpack(cls, data: bytes) -> "TickReply":
        """From 16 bytes. Raises struct.error when there are more or fewer."""
        return cls(*struct.unpack(cls.FORMAT, data))
