"""Messages of protocol/rover.dbc, raw integers as on the wire.

Written by `python -m tools.generate`: change the DBC, not this file.
"""

from rover_protocol.message import Message

SCHEMA_HASH = 0x48FDA56D

# Cut the motors at once and latch. Needs no state, is never refused.
EmergencyStop = Message("EmergencyStop", 0x008, 1, (("reason", 0, 1, False),))
# Jerk-limited stop, then latch. Idempotent.
Stop = Message("Stop", 0x010, 1, (("reason", 0, 1, False),))
# Arm or re-arm, edge-triggered: acts only when token is later than every token seen before, so that a late copy does nothing. Refused (fault counted) from another session or wire than the last Hello that was accepted, with the emergency-stop input active, with the battery too low, or without a sensor that driving needs.
Arm = Message("Arm", 0x018, 4, (("token", 0, 2, False), ("session", 2, 2, False),))
# Stop jerk-limited, then switch the motors off without a latch.
Disarm = Message("Disarm", 0x019, 1, (("reason", 0, 1, False),))
# Feeds the dead-man while no motion is streamed.
KeepAlive = Message("KeepAlive", 0x020, 1, (("counter", 0, 1, False),))
# Asks for the firmware's clock.
ClockRequest = Message("ClockRequest", 0x030, 1, (("sequence", 0, 1, False),))
# Answer to ClockRequest.
ClockReply = Message("ClockReply", 0x031, 7, (("sequence", 0, 1, False), ("receive_time", 1, 4, False), ("turnaround", 5, 2, False),))
# First half of a constant-jerk segment: how long, and the jerk of travel.
SegmentTravel = Message("SegmentTravel", 0x040, 8, (("index", 0, 2, False), ("duration", 2, 3, False), ("jerk_travel", 5, 3, True),))
# Second half: the jerk of heading, and how the segment joins its neighbours. The segment is accepted when both halves of the next expected index are there.
SegmentHeading = Message("SegmentHeading", 0x041, 6, (("index", 0, 2, False), ("jerk_heading", 2, 3, True), ("flags", 5, 1, False),))
# When the run that begins with this index starts. Must arrive before the begin segment is complete.
SegmentStart = Message("SegmentStart", 0x042, 6, (("index", 0, 2, False), ("start_time", 2, 4, False),))
# Acknowledges segments and tells the room left. Sent after every segment received and at the telemetry rate.
MotionStatus = Message("MotionStatus", 0x050, 8, (("next_index", 0, 2, False), ("free_slots", 2, 1, False), ("queued", 3, 1, False), ("executing", 4, 2, False), ("rejected", 6, 2, False),))
# Heartbeat of the firmware; once a second on a CAN bus on which no companion speaks to it.
State = Message("State", 0x060, 8, (("state", 0, 1, False), ("cause", 1, 1, False), ("cause_detail", 2, 1, False), ("faults", 3, 2, False), ("arm_token", 5, 2, False), ("flags", 7, 1, False),))
# Quadrature counts, x4.
WheelTicks = Message("WheelTicks", 0x070, 8, (("time", 0, 2, False), ("left", 2, 3, True), ("right", 5, 3, True),))
# Dead-reckoned position since boot.
OdometryPosition = Message("OdometryPosition", 0x071, 8, (("x", 0, 4, True), ("y", 4, 4, True),))
# Dead-reckoned heading since boot, with the time of both odometry messages.
OdometryHeading = Message("OdometryHeading", 0x072, 8, (("heading", 0, 4, True), ("time", 4, 4, False),))
# Reference and measured motion.
Velocity = Message("Velocity", 0x073, 8, (("reference_travel", 0, 2, True), ("reference_heading", 2, 2, True), ("measured_travel", 4, 2, True), ("measured_heading", 6, 2, True),))
# Where along the commanded motion the firmware is.
ReferenceDistance = Message("ReferenceDistance", 0x074, 8, (("travel", 0, 4, True), ("heading", 4, 4, True),))
# What the gyroscope has turned by about the rover's vertical since it was heard first, its bias at rest taken off. Sent while there is an inertial sensor that can be believed; a gap longer than 30 ms means that turns are missing.
InertialHeading = Message("InertialHeading", 0x075, 8, (("heading", 0, 4, True), ("rate", 4, 2, True), ("time", 6, 2, False),))
# Which way is up on base_link, as a rover at rest would feel it: 9.81 m/s^2 along z when it stands level. Sent once there has been an inertial sensor.
Gravity = Message("Gravity", 0x076, 8, (("x", 0, 2, True), ("y", 2, 2, True), ("z", 4, 2, True), ("shake", 6, 1, False), ("status", 7, 1, False),))
# One ultrasonic ranging.
Sonar = Message("Sonar", 0x080, 8, (("sensor", 0, 1, False), ("status", 1, 1, False), ("range", 2, 2, False), ("time", 4, 4, False),))
# Battery.
Battery = Message("Battery", 0x090, 4, (("voltage", 0, 2, False), ("minimum", 2, 2, False),))
# Duty of both motors.
MotorDuty = Message("MotorDuty", 0x091, 4, (("left", 0, 2, True), ("right", 2, 2, True),))
# A fault has come or its counter has changed.
Fault = Message("Fault", 0x0A0, 8, (("code", 0, 1, False), ("active", 1, 1, False), ("count", 2, 2, False), ("detail", 4, 4, False),))
# What the firmware's receiver has seen, since boot, wrapping.
LinkStatistics = Message("LinkStatistics", 0x0A1, 8, (("frames", 0, 2, False), ("checksum_errors", 2, 2, False), ("malformed", 4, 2, False), ("lost", 6, 2, False),))
# A piece of a log line.
LogText = Message("LogText", 0x0B0, 8, (("offset", 0, 1, False), ("text", 1, 7, False),))
# Handshake.
Hello = Message("Hello", 0x100, 6, (("schema_hash", 0, 4, False), ("session", 4, 2, False),))
# Answer to Hello.
HelloReply = Message("HelloReply", 0x101, 8, (("schema_hash", 0, 4, False), ("version_major", 4, 1, False), ("version_minor", 5, 1, False), ("version_patch", 6, 1, False), ("board", 7, 1, False),))
# Second answer to Hello.
HelloBuild = Message("HelloBuild", 0x102, 8, (("git_hash", 0, 4, False), ("reset_cause", 4, 1, False), ("accepted", 5, 1, False), ("session", 6, 2, False),))
# Answer to Hello, on the wire that it came by: another session drives the rover and keeps it until the motors are off.
HelloBusy = Message("HelloBusy", 0x103, 5, (("session", 0, 2, False), ("holder", 2, 2, False), ("wire", 4, 1, False),))
# Asks for a parameter.
ParameterGet = Message("ParameterGet", 0x110, 2, (("identifier", 0, 2, False),))
# Sets a parameter in memory.
ParameterSet = Message("ParameterSet", 0x111, 6, (("identifier", 0, 2, False), ("value", 2, 4, True),))
# Answer to both.
ParameterValue = Message("ParameterValue", 0x112, 7, (("identifier", 0, 2, False), ("value", 2, 4, True), ("status", 6, 1, False),))
# Save all parameters, or go back to defaults.
ParameterCommand = Message("ParameterCommand", 0x113, 1, (("command", 0, 1, False),))
# Period of one telemetry message.
TelemetryRate = Message("TelemetryRate", 0x120, 4, (("message", 0, 2, False), ("period", 2, 2, False),))
# Sensors from the wire instead of the pins, motors off whatever the state. Refused while the motors are on and before a matching Hello. Answered by State.
TestMode = Message("TestMode", 0x130, 3, (("enable", 0, 1, False), ("key", 1, 2, False),))
# Quadrature counts in test mode.
InjectWheels = Message("InjectWheels", 0x131, 8, (("left", 0, 4, True), ("right", 4, 4, True),))
# All other measurements in test mode.
InjectSensors = Message("InjectSensors", 0x132, 8, (("battery", 0, 2, False), ("emergency_stop", 2, 1, False), ("sonar", 3, 1, False), ("echo", 4, 3, False), ("bumper", 7, 1, False),))
# Asks for the record of the last crash, or clears it.
CrashRequest = Message("CrashRequest", 0x140, 1, (("command", 0, 1, False),))
# Answer to CrashRequest: what crashed. Cause None and nothing more when there is no record.
CrashCause = Message("CrashCause", 0x141, 8, (("cause", 0, 1, False), ("task", 1, 1, False), ("detail", 2, 2, False), ("program_counter", 4, 4, False),))
# Second answer to CrashRequest.
CrashTime = Message("CrashTime", 0x142, 7, (("uptime", 0, 4, False), ("stack", 4, 2, False), ("events", 6, 1, False),))
# One of the last events before the crash, the oldest first.
CrashEvent = Message("CrashEvent", 0x143, 8, (("index", 0, 1, False), ("kind", 1, 1, False), ("detail", 2, 2, False), ("time", 4, 4, False),))
# Restarts. Ignored while armed, while a wheel turns, and from another session or wire than the last Hello, whatever its schema.
Reboot = Message("Reboot", 0x7F0, 6, (("magic", 0, 4, False), ("session", 4, 2, False),))

BY_ID = {
    0x008: EmergencyStop,
    0x010: Stop,
    0x018: Arm,
    0x019: Disarm,
    0x020: KeepAlive,
    0x030: ClockRequest,
    0x031: ClockReply,
    0x040: SegmentTravel,
    0x041: SegmentHeading,
    0x042: SegmentStart,
    0x050: MotionStatus,
    0x060: State,
    0x070: WheelTicks,
    0x071: OdometryPosition,
    0x072: OdometryHeading,
    0x073: Velocity,
    0x074: ReferenceDistance,
    0x075: InertialHeading,
    0x076: Gravity,
    0x080: Sonar,
    0x090: Battery,
    0x091: MotorDuty,
    0x0A0: Fault,
    0x0A1: LinkStatistics,
    0x0B0: LogText,
    0x100: Hello,
    0x101: HelloReply,
    0x102: HelloBuild,
    0x103: HelloBusy,
    0x110: ParameterGet,
    0x111: ParameterSet,
    0x112: ParameterValue,
    0x113: ParameterCommand,
    0x120: TelemetryRate,
    0x130: TestMode,
    0x131: InjectWheels,
    0x132: InjectSensors,
    0x140: CrashRequest,
    0x141: CrashCause,
    0x142: CrashTime,
    0x143: CrashEvent,
    0x7F0: Reboot,
}
BY_NAME = {message.name: message for message in BY_ID.values()}

# Physical value = raw value * scale; fields that are not here are plain counts and codes.
SCALES: dict[str, dict[str, float]] = {
    "ClockReply": {"receive_time": 1e-06, "turnaround": 1e-06},
    "SegmentTravel": {"duration": 1e-06, "jerk_travel": 1e-06},
    "SegmentHeading": {"jerk_heading": 1e-06},
    "SegmentStart": {"start_time": 1e-06},
    "WheelTicks": {"time": 0.001},
    "OdometryPosition": {"x": 1e-05, "y": 1e-05},
    "OdometryHeading": {"heading": 1e-06, "time": 1e-06},
    "Velocity": {"reference_travel": 0.0001, "reference_heading": 0.001, "measured_travel": 0.0001, "measured_heading": 0.001},
    "ReferenceDistance": {"travel": 1e-05, "heading": 1e-06},
    "InertialHeading": {"heading": 1e-06, "rate": 0.001, "time": 0.001},
    "Gravity": {"x": 0.001, "y": 0.001, "z": 0.001, "shake": 0.1},
    "Sonar": {"range": 0.001, "time": 1e-06},
    "Battery": {"voltage": 0.001, "minimum": 0.001},
    "MotorDuty": {"left": 3.0517578125e-05, "right": 3.0517578125e-05},
    "TelemetryRate": {"period": 0.001},
    "InjectSensors": {"battery": 0.001, "echo": 1e-06},
    "CrashTime": {"uptime": 0.001},
    "CrashEvent": {"time": 0.001},
}

# State.state
STATE_BOOT = 0
STATE_DISARMED = 1
STATE_ARMED = 2
STATE_MOVING = 3
STATE_STOPPING = 4
STATE_LATCHED = 5
STATE_NAMES = {0: "Boot", 1: "Disarmed", 2: "Armed", 3: "Moving", 4: "Stopping", 5: "Latched"}

# State.cause
STATE_CAUSE_NONE = 0
STATE_CAUSE_STOP_COMMAND = 1
STATE_CAUSE_EMERGENCY_COMMAND = 2
STATE_CAUSE_EMERGENCY_INPUT = 3
STATE_CAUSE_DEAD_MAN = 4
STATE_CAUSE_SONAR_GUARD = 5
STATE_CAUSE_LOW_BATTERY = 6
STATE_CAUSE_STALL = 7
STATE_CAUSE_ENCODER_FAULT = 8
STATE_CAUSE_UNDERRUN = 9
STATE_CAUSE_DISARM = 10
STATE_CAUSE_INTERNAL = 11
STATE_CAUSE_INJECTOR_SILENT = 12
STATE_CAUSE_SENSOR_LOST = 13
STATE_CAUSE_BUMPER = 14
STATE_CAUSE_NAMES = {0: "None", 1: "StopCommand", 2: "EmergencyCommand", 3: "EmergencyInput", 4: "DeadMan", 5: "SonarGuard", 6: "LowBattery", 7: "Stall", 8: "EncoderFault", 9: "Underrun", 10: "Disarm", 11: "Internal", 12: "InjectorSilent", 13: "SensorLost", 14: "Bumper"}

# Gravity.status
GRAVITY_STATUS_SETTLING = 0
GRAVITY_STATUS_GOOD = 1
GRAVITY_STATUS_LOST = 2
GRAVITY_STATUS_NAMES = {0: "Settling", 1: "Good", 2: "Lost"}

# Sonar.status
SONAR_STATUS_OK = 0
SONAR_STATUS_NO_ECHO = 1
SONAR_STATUS_DEAD = 2
SONAR_STATUS_NAMES = {0: "Ok", 1: "NoEcho", 2: "Dead"}

# Fault.code
FAULT_CODE_NONE = 0
FAULT_CODE_DEAD_MAN = 1
FAULT_CODE_SONAR_GUARD = 2
FAULT_CODE_LOW_BATTERY = 3
FAULT_CODE_STALL = 4
FAULT_CODE_ENCODER_LEFT = 5
FAULT_CODE_ENCODER_RIGHT = 6
FAULT_CODE_SONAR_DEAD = 7
FAULT_CODE_UNDERRUN = 8
FAULT_CODE_SEGMENT_REJECTED = 9
FAULT_CODE_ARM_REFUSED = 10
FAULT_CODE_QUEUE_FULL = 11
FAULT_CODE_TRANSMIT_OVERFLOW = 12
FAULT_CODE_RECEIVE_OVERFLOW = 13
FAULT_CODE_SCHEMA_MISMATCH = 14
FAULT_CODE_WATCHDOG = 15
FAULT_CODE_INERTIAL_LOST = 16
FAULT_CODE_NAMES = {0: "None", 1: "DeadMan", 2: "SonarGuard", 3: "LowBattery", 4: "Stall", 5: "EncoderLeft", 6: "EncoderRight", 7: "SonarDead", 8: "Underrun", 9: "SegmentRejected", 10: "ArmRefused", 11: "QueueFull", 12: "TransmitOverflow", 13: "ReceiveOverflow", 14: "SchemaMismatch", 15: "Watchdog", 16: "InertialLost"}

# HelloReply.board
HELLO_REPLY_BOARD_SITL = 0
HELLO_REPLY_BOARD_RP2040 = 1
HELLO_REPLY_BOARD_RP2350 = 2
HELLO_REPLY_BOARD_MICRO_PYTHON = 3
HELLO_REPLY_BOARD_NAMES = {0: "Sitl", 1: "Rp2040", 2: "Rp2350", 3: "MicroPython"}

# HelloBuild.reset_cause
HELLO_BUILD_RESET_CAUSE_POWER_ON = 0
HELLO_BUILD_RESET_CAUSE_WATCHDOG = 1
HELLO_BUILD_RESET_CAUSE_SOFTWARE = 2
HELLO_BUILD_RESET_CAUSE_BROWN_OUT = 3
HELLO_BUILD_RESET_CAUSE_UNKNOWN = 4
HELLO_BUILD_RESET_CAUSE_NAMES = {0: "PowerOn", 1: "Watchdog", 2: "Software", 3: "BrownOut", 4: "Unknown"}

# HelloBusy.wire
HELLO_BUSY_WIRE_SERIAL = 0
HELLO_BUSY_WIRE_CAN = 1
HELLO_BUSY_WIRE_NAMES = {0: "Serial", 1: "Can"}

# ParameterValue.status
PARAMETER_VALUE_STATUS_OK = 0
PARAMETER_VALUE_STATUS_UNKNOWN_PARAMETER = 1
PARAMETER_VALUE_STATUS_OUT_OF_RANGE = 2
PARAMETER_VALUE_STATUS_REFUSED_WHILE_ARMED = 3
PARAMETER_VALUE_STATUS_STORAGE_ERROR = 4
PARAMETER_VALUE_STATUS_NAMES = {0: "Ok", 1: "UnknownParameter", 2: "OutOfRange", 3: "RefusedWhileArmed", 4: "StorageError"}

# ParameterCommand.command
PARAMETER_COMMAND_SAVE = 0
PARAMETER_COMMAND_DEFAULTS = 1
PARAMETER_COMMAND_LOAD = 2
PARAMETER_COMMAND_NAMES = {0: "Save", 1: "Defaults", 2: "Load"}

# CrashRequest.command
CRASH_REQUEST_COMMAND_READ = 0
CRASH_REQUEST_COMMAND_CLEAR = 1
CRASH_REQUEST_COMMAND_NAMES = {0: "Read", 1: "Clear"}

# CrashCause.cause
CRASH_CAUSE_NONE = 0
CRASH_CAUSE_PANIC = 1
CRASH_CAUSE_HARD_FAULT = 2
CRASH_CAUSE_WATCHDOG = 3
CRASH_CAUSE_NAMES = {0: "None", 1: "Panic", 2: "HardFault", 3: "Watchdog"}

# CrashCause.task
CRASH_CAUSE_TASK_IDLE = 0
CRASH_CAUSE_TASK_CONTROL = 1
CRASH_CAUSE_TASK_EMERGENCY_STOP = 2
CRASH_CAUSE_TASK_SONAR = 3
CRASH_CAUSE_TASK_CAN = 4
CRASH_CAUSE_TASK_USB = 5
CRASH_CAUSE_TASK_LIFE = 6
CRASH_CAUSE_TASK_LINK = 7
CRASH_CAUSE_TASK_BATTERY = 8
CRASH_CAUSE_TASK_INERTIAL = 9
CRASH_CAUSE_TASK_NAMES = {0: "Idle", 1: "Control", 2: "EmergencyStop", 3: "Sonar", 4: "Can", 5: "Usb", 6: "Life", 7: "Link", 8: "Battery", 9: "Inertial"}

# CrashEvent.kind
CRASH_EVENT_KIND_NONE = 0
CRASH_EVENT_KIND_START = 1
CRASH_EVENT_KIND_STATE = 2
CRASH_EVENT_KIND_FAULT = 3
CRASH_EVENT_KIND_FAULT_OVER = 4
CRASH_EVENT_KIND_REBOOT = 5
CRASH_EVENT_KIND_NAMES = {0: "None", 1: "Start", 2: "State", 3: "Fault", 4: "FaultOver", 5: "Reboot"}

# Value tables by message and field: VALUES["State"]["cause"][4] == "DeadMan".
VALUES: dict[str, dict[str, dict[int, str]]] = {
    "State": {"state": STATE_NAMES, "cause": STATE_CAUSE_NAMES},
    "Gravity": {"status": GRAVITY_STATUS_NAMES},
    "Sonar": {"status": SONAR_STATUS_NAMES},
    "Fault": {"code": FAULT_CODE_NAMES},
    "HelloReply": {"board": HELLO_REPLY_BOARD_NAMES},
    "HelloBuild": {"reset_cause": HELLO_BUILD_RESET_CAUSE_NAMES},
    "HelloBusy": {"wire": HELLO_BUSY_WIRE_NAMES},
    "ParameterValue": {"status": PARAMETER_VALUE_STATUS_NAMES},
    "ParameterCommand": {"command": PARAMETER_COMMAND_NAMES},
    "CrashRequest": {"command": CRASH_REQUEST_COMMAND_NAMES},
    "CrashCause": {"cause": CRASH_CAUSE_NAMES, "task": CRASH_CAUSE_TASK_NAMES},
    "CrashEvent": {"kind": CRASH_EVENT_KIND_NAMES},
}


def decode(identifier: int, payload: bytes | bytearray) -> tuple[Message, dict[str, int | bytes]]:
    """(Message, {field: raw value}) of a received frame.

    Raises ValueError for an unknown identifier or a payload of the wrong length.
    """
    message = BY_ID.get(identifier)
    if message is None:
        raise ValueError(f"unknown identifier 0x{identifier:03x}")
    return message, message.decode(payload)


def physical(message: Message, values: dict[str, int | bytes]) -> dict[str, int | float | bytes]:
    """The raw `values` of decode() in SI units, as the DBC scales them; texts stay bytes."""
    scales = SCALES.get(message.name, {})
    return {
        name: value * scales[name] if name in scales and not isinstance(value, bytes) else value
        for name, value in values.items()
    }
