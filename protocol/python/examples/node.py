"""A node of the rover's link on any MicroPython board: handshake, clock, heartbeat, and one ultrasonic sensor.

This file knows no pins and no UART, so that it runs anywhere; main.py beside it brings both. Nothing here moves: a
node refuses to be armed.
"""

from rover_protocol import framing, messages

HEARTBEAT_US = 100_000
COMPANION_SILENT_US = 300_000
VERSION = (0, 1, 0)
# Sound in air at 20 °C.
MILLIMETRES_PER_SECOND = 343_000
SILENT_PINGS_OF_A_DEAD_SENSOR = 10
NO_RANGE = 0xFFFF
HANDSHAKE_DONE = 1
WRAP = 0xFFFFFFFF


class Node:
    """One end of a serial line.

    write(buffer, length) puts bytes on the line; now() is the board's time in µs, 32 bits, wrapping; sensor is the
    number that ranges are reported under: 0 left, 1 centre, 2 right.
    """

    def __init__(self, write, now, sensor=1, git_hash=0):
        self.decoder = framing.Decoder()
        self.handshake_done = False
        self._write = write
        self._now = now
        self._sensor = sensor
        self._git_hash = git_hash
        self._frame = bytearray(framing.MAX_FRAME)
        self._payload = bytearray(framing.MAX_PAYLOAD)
        self._values = [0] * 8
        self._sequence = 0
        self._heartbeat_due = now()
        self._keep_alive = -1
        self._heard_at = None
        self._arm_token = 0
        self._refused = 0
        self._echoes = []
        self._silent = 0

    def receive(self, data):
        """Takes bytes of the line and answers what has to be answered."""
        for byte in data:
            if self.decoder.push(byte):
                self._take(self._now())

    def tick(self):
        """Call it every few milliseconds: sends the heartbeat when it is due."""
        now = self._now()
        if (now - self._heartbeat_due) & WRAP < 0x80000000:
            self._heartbeat_due = (now + HEARTBEAT_US) & WRAP
            self._send_state()

    def companion_is_there(self):
        """True while keep-alives count up. What a node drives must stop when this is no longer so."""
        return self._heard_at is not None and (self._now() - self._heard_at) & WRAP < COMPANION_SILENT_US

    def ranged(self, echo_us, pinged_at):
        """Reports a ranging: µs that the echo pin was high; 0 when no echo came back, -1 when the pin never rose."""
        self._silent = self._silent + 1 if echo_us < 0 else 0
        if self._silent >= SILENT_PINGS_OF_A_DEAD_SENSOR:
            self._send(messages.Sonar, self._sensor, messages.SONAR_STATUS_DEAD, NO_RANGE, pinged_at)
            return
        if echo_us < 0:
            return
        # There and back; the median of three loses what a single wrong echo says.
        self._echoes.append(echo_us * MILLIMETRES_PER_SECOND // 2_000_000 if echo_us else NO_RANGE)
        if len(self._echoes) > 3:
            self._echoes.pop(0)
        distance = sorted(self._echoes)[len(self._echoes) // 2]
        status = messages.SONAR_STATUS_NO_ECHO if distance == NO_RANGE else messages.SONAR_STATUS_OK
        self._send(messages.Sonar, self._sensor, status, distance, pinged_at)

    def _take(self, now):
        message = messages.BY_ID.get(self.decoder.identifier)
        if message is None or self.decoder.length != message.LENGTH:
            return
        values = self._values
        message.unpack_into(self.decoder.payload, values)
        if message is messages.Hello:
            self._answer_hello(values[0], values[1])
        elif message is messages.ClockRequest:
            turnaround = min((self._now() - now) & WRAP, 0xFFFF)
            self._send(messages.ClockReply, values[0], now, turnaround)
        elif message is messages.KeepAlive:
            # A sender that hangs with a full buffer repeats itself, and a late copy is no sign of life either.
            if self._keep_alive < 0 or 0 < (values[0] - self._keep_alive) & 0xFF < 0x80:
                self._keep_alive = values[0]
                self._heard_at = now
        elif message is messages.Arm and 0 < (values[0] - self._arm_token) & 0xFFFF < 0x8000:
            self._arm_token = values[0]
            self._refused += 1
            self._send(messages.Fault, messages.FAULT_CODE_ARM_REFUSED, 0, self._refused & 0xFFFF, 0)
            self._send_state()

    def _answer_hello(self, schema_hash, session):
        same = schema_hash == messages.SCHEMA_HASH
        self._keep_alive = -1
        self.handshake_done = same
        board = messages.HELLO_REPLY_BOARD_MICRO_PYTHON
        self._send(messages.HelloReply, messages.SCHEMA_HASH, VERSION[0], VERSION[1], VERSION[2], board)
        cause = messages.HELLO_BUILD_RESET_CAUSE_UNKNOWN
        self._send(messages.HelloBuild, self._git_hash, cause, 1 if same else 0, session)
        self._send_state()

    def _send_state(self):
        flags = HANDSHAKE_DONE if self.handshake_done else 0
        none = messages.STATE_CAUSE_NONE
        self._send(messages.State, messages.STATE_DISARMED, none, 0, 0, self._arm_token, flags)

    def _send(self, message, *values):
        length = message.pack_into(self._payload, values)
        length = framing.encode_into(message.ID, self._sequence, self._payload, length, self._frame)
        self._sequence = (self._sequence + 1) & 0xFF
        self._write(self._frame, length)
