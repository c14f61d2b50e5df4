"""One tick on the pipes, in the terms of the emulated board."""

from __future__ import annotations

from dataclasses import dataclass

from rover_protocol.rig_tick import BUZZER, LED, NO_SENSOR, POWERED, TickReply, TickRequest

FULL_DUTY = 1 << 15


@dataclass(frozen=True)
class Request:
    """The world at `now_us`."""

    now_us: int
    counts: tuple[int, int]
    battery_mv: int
    emergency_stop: bool
    host_bytes_due: int
    ping: tuple[int, int] | None
    """Sensor that was triggered in the last tick, and the length of its echo in µs; 0: none will come."""
    bumper: bool = False
    inertial: int = 0
    """As in TickRequest; the next three are what the sensor has in its registers."""
    gyro: tuple[int, int, int] = (0, 0, 0)
    acceleration: tuple[int, int, int] = (0, 0, 0)
    temperature: int = 0

    @classmethod
    def unpack(cls, data: bytes) -> Request:
        """From a TickRequest's bytes. Its finished echo is for rover-sitl; pins get their edges from `ping`."""
        tick = TickRequest.unpack(data)
        return cls(
            now_us=tick.now_us,
            counts=(tick.encoder_left, tick.encoder_right),
            battery_mv=tick.battery_mv,
            emergency_stop=bool(tick.emergency_stop),
            host_bytes_due=tick.host_bytes_due,
            ping=(tick.ping - 1, tick.ping_echo_us) if tick.ping else None,
            bumper=bool(tick.bumper),
            inertial=tick.inertial,
            gyro=(tick.gyro_x, tick.gyro_y, tick.gyro_z),
            acceleration=(tick.acceleration_x, tick.acceleration_y, tick.acceleration_z),
            temperature=tick.temperature,
        )


@dataclass(frozen=True)
class Reply:
    """The outputs at the end of the millisecond. Duties -1 to 1."""

    duty: tuple[float, float]
    powered: bool
    led: bool
    buzzer: bool
    trigger: int | None
    bytes_sent: int

    def pack(self) -> bytes:
        """As a TickReply's bytes."""
        left, right = (max(-FULL_DUTY, min(FULL_DUTY - 1, round(duty * FULL_DUTY))) for duty in self.duty)
        return TickReply(
            duty_left=left,
            duty_right=right,
            flags=POWERED * self.powered | LED * self.led | BUZZER * self.buzzer,
            sonar_trigger=NO_SENSOR if self.trigger is None else self.trigger,
            bytes_sent=self.bytes_sent,
        ).pack()
