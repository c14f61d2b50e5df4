"""Names that the firmware's messages carry, for code that acts on them; a test holds them against rover.dbc."""

from __future__ import annotations

from rover.str_enum import StrEnum


class MotorState(StrEnum):
    """State.state: whether the motors may turn."""

    BOOT = "Boot"
    DISARMED = "Disarmed"
    ARMED = "Armed"
    MOVING = "Moving"
    STOPPING = "Stopping"
    LATCHED = "Latched"


class StopCause(StrEnum):
    """State.cause: why the firmware last stopped the rover."""

    NONE = "None"
    STOP_COMMAND = "StopCommand"
    EMERGENCY_COMMAND = "EmergencyCommand"
    EMERGENCY_INPUT = "EmergencyInput"
    DEAD_MAN = "DeadMan"
    SONAR_GUARD = "SonarGuard"
    LOW_BATTERY = "LowBattery"
    STALL = "Stall"
    ENCODER_FAULT = "EncoderFault"
    UNDERRUN = "Underrun"
    DISARM = "Disarm"
    INTERNAL = "Internal"
    INJECTOR_SILENT = "InjectorSilent"
    SENSOR_LOST = "SensorLost"
    BUMPER = "Bumper"


class FaultCode(StrEnum):
    """Fault.code, and the bits of State.faults."""

    NONE = "None"
    DEAD_MAN = "DeadMan"
    SONAR_GUARD = "SonarGuard"
    LOW_BATTERY = "LowBattery"
    STALL = "Stall"
    ENCODER_LEFT = "EncoderLeft"
    ENCODER_RIGHT = "EncoderRight"
    SONAR_DEAD = "SonarDead"
    UNDERRUN = "Underrun"
    SEGMENT_REJECTED = "SegmentRejected"
    ARM_REFUSED = "ArmRefused"
    QUEUE_FULL = "QueueFull"
    TRANSMIT_OVERFLOW = "TransmitOverflow"
    RECEIVE_OVERFLOW = "ReceiveOverflow"
    SCHEMA_MISMATCH = "SchemaMismatch"
    WATCHDOG = "Watchdog"
    INERTIAL_LOST = "InertialLost"


class SonarStatus(StrEnum):
    """Sonar.status: what came of one ranging."""

    OK = "Ok"
    NO_ECHO = "NoEcho"
    DEAD = "Dead"
