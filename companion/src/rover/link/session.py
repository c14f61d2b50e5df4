"""The companion's end of the link: handshake, keep-alive, clock, arming, motion and telemetry in one `poll`.

    link = Link(SerialTransport(port), WallClock())
    identity = link.connect()
    link.arm()
    while ...:
        for event in link.poll():
            ...
        link.clock.advance(link.clock.now() + 0.02)

Nothing here waits but `connect`, `arm`, `disarm` and the parameter calls, and these let the clock run on.
"""

from __future__ import annotations

import secrets
from collections import deque
from collections.abc import Callable

from rover_protocol import messages

from rover.errors import LinkLost, PreflightFailed, SafetyStop
from rover.link.clock import Clock
from rover.link.clock_estimate import ClockEstimate
from rover.link.frames import FrameTransport
from rover.link.handshake import Handshake, Identity
from rover.link.statistics import LinkFigures, percentile
from rover.link.stream import SegmentStream
from rover.link.telemetry import (
    FaultReport,
    FirmwareState,
    LinkQuality,
    MotionStatus,
    ParameterValue,
    Telemetry,
    TelemetryReader,
)
from rover.link.transport import Transport
from rover.link.wire import Received, Tap, Wire

# Fifteen within the dead-man's 300 ms, so that a wire which loses a fifth of them does not stop the rover.
KEEP_ALIVE_PERIOD_S = 0.02

CLOCK_PERIOD_S = 0.5
CLOCK_PERIOD_FAST_S = 0.06
CLOCK_FAST_COUNT = 20
# Seconds after which a clock request that was not answered is asked again.
CLOCK_ANSWER_TIMEOUT_S = 0.1

# Seconds between two looks at the wire from which on it is the host that has stood still, not the wire.
STALL_S = 0.25

# Seconds without a byte after which the link counts as lost; the firmware says something every 20 ms.
MAX_SILENCE_S = 1.0

STEP_S = 0.02
DRIVEABLE = ("Armed", "Moving")


class Link:
    """One session with one firmware. Every method may raise `LinkLost`."""

    def __init__(
        self,
        transport: Transport | FrameTransport,
        clock: Clock,
        session: int | None = None,
        tap: Tap | None = None,
    ) -> None:
        """`session`: 16-bit number that the firmware knows this companion by; drawn when left out."""
        self.clock = clock
        self.wire = Wire(transport, tap)
        self.clock_estimate = ClockEstimate(self.wire.transport.time_step)
        self.stream = SegmentStream(self._send, self.clock_estimate)
        self.identity: Identity | None = None
        self.state: FirmwareState | None = None
        self.quality: LinkQuality | None = None
        self.round_trips: list[float] = []
        self._handshake = Handshake(secrets.randbelow(1 << 16) if session is None else session & 0xFFFF)
        self._reader = TelemetryReader(self.clock_estimate)
        self._keep_alive_counter = 0
        self._keep_alive_due = 0.0
        self._clock_sequence = 0
        self._clock_due = 0.0
        self._clock_sent: dict[int, float] = {}
        self._backlog: deque[Telemetry] = deque()
        self._silent_since: float | None = None
        # When the wire was last looked at for its silence, seconds.
        self._looked: float | None = None
        self._stop_wanted: tuple[str, int] | None = None

    @property
    def session_number(self) -> int:
        """What the firmware knows this companion by."""
        return self._handshake.session

    def connect(self, timeout: float = 3.0) -> Identity:
        """Handshake and first clock exchanges.

        Raises PreflightFailed when nothing answers within `timeout` or the firmware speaks another protocol.
        """
        start = self.clock.now()
        hello_due = start
        while not (self._handshake.done and self.clock_estimate.count >= 3 and self.state is not None):
            now = self.clock.now()
            if now - start > timeout:
                raise PreflightFailed(self._no_answer(timeout))
            if not self._handshake.done and now >= hello_due:
                self._send("Hello", schema_hash=messages.SCHEMA_HASH, session=self._handshake.session)
                hello_due = now + 0.2
            self._keep(self._exchange(guard=False))
            self.clock.advance(now + STEP_S)
        self.identity = self._handshake.identity()
        self._silent_since = self.clock.now()
        return self.identity

    def poll(self) -> list[Telemetry]:
        """Reads, decodes, keeps alive, asks the clock and streams motion. Call it every 20 ms.

        Raises LinkLost after a second of silence, SafetyStop when the firmware has restarted.
        """
        events = list(self._backlog)
        self._backlog.clear()
        events.extend(self._exchange(guard=True))
        return events

    def arm(self, timeout: float = 2.0) -> None:
        """Arms, or re-arms after a latch. Raises PreflightFailed with the firmware's reason when it does not."""
        self._wait_for_state(timeout)
        assert self.state is not None
        token = (self.state.arm_token + 1) & 0xFFFF
        self._stop_wanted = None
        self.stream.clear(self.clock.now())
        refused: list[FaultReport] = []

        def armed(event: Telemetry) -> bool:
            if isinstance(event, FaultReport) and event.code == "ArmRefused":
                refused.append(event)
            # Of the answers only one with our token tells what came of it.
            state = self.state
            return state is not None and state.arm_token == token and state.state in DRIVEABLE

        if not self._request(lambda: self._send("Arm", token=token, session=self._handshake.session), armed, timeout):
            raise PreflightFailed(self._arm_refusal(bool(refused)))

    def disarm(self, timeout: float = 3.0) -> bool:
        """Stops jerk-limited and switches the motors off, without a latch; False when it is not confirmed in time."""
        self.stream.clear(self.clock.now())

        def disarmed(_: Telemetry) -> bool:
            return self.state is not None and self.state.state in ("Disarmed", "Boot", "Latched")

        return self._request(lambda: self._send("Disarm", reason=0), disarmed, timeout)

    def stop(self, reason: int = 0) -> None:
        """Jerk-limited stop, then latch. `poll` repeats it until the firmware's state says that it has come."""
        self._demand("Stop", reason, 1)

    def emergency_stop(self, reason: int = 0) -> None:
        """Cuts the motors at once and latches. Sent three times: it costs nothing and a lost one costs much.

        `poll` repeats it as it does `stop`.
        """
        self._demand("EmergencyStop", reason, 3)

    def get_parameter(self, identifier: int, timeout: float = 0.5) -> ParameterValue:
        """Reads one parameter. Raises PreflightFailed when the firmware does not answer."""
        return self._parameter(identifier, timeout, lambda: self._send("ParameterGet", identifier=identifier))

    def set_parameter(self, identifier: int, value: int, timeout: float = 0.5) -> ParameterValue:
        """Sets one parameter in memory; the answer says whether it was taken."""
        return self._parameter(
            identifier, timeout, lambda: self._send("ParameterSet", identifier=identifier, value=value)
        )

    def request_parameter(self, identifier: int) -> None:
        """Asks for a parameter without waiting: the answer comes by `poll`."""
        self._send("ParameterGet", identifier=identifier)

    def command_parameters(self, command: int) -> None:
        """A ParameterCommand, without waiting: save, defaults or load. The answer comes by `poll`."""
        self._send("ParameterCommand", command=command)

    def set_telemetry_period(self, message: str, period: float) -> None:
        """Period of one telemetry message in seconds; 0 switches it off."""
        self._send("TelemetryRate", message=messages.BY_NAME[message].ID, period=round(period * 1000.0))

    def figures(self) -> LinkFigures:
        """Counts and times since the link came up."""
        counters, quality, stream = self.wire.counters, self.quality, self.stream
        return LinkFigures(
            frames_received=counters.frames,
            frames_sent=self.wire.frames_sent,
            lost=counters.lost,
            checksum_errors=counters.checksum_errors,
            malformed=counters.malformed,
            unknown=self.wire.unknown,
            bytes_received=self.wire.transport.bytes_read,
            bytes_sent=self.wire.transport.bytes_written,
            firmware_lost=quality.lost if quality else 0,
            firmware_checksum_errors=quality.checksum_errors if quality else 0,
            segments_sent=stream.sent,
            segments_repeated=stream.repeated,
            segments_accepted=stream.accepted,
            segments_rejected=stream.status.rejected if stream.status else 0,
            runs_postponed=stream.postponed,
            clock_exchanges=self.clock_estimate.count,
            clock_error_bound=self.clock_estimate.error_bound,
            clock_drift=self.clock_estimate.drift,
            round_trip_median=percentile(self.round_trips, 0.5),
            round_trip_p99=percentile(self.round_trips, 0.99),
        )

    def close(self) -> None:
        """Lets the port go; the firmware's dead-man does the rest."""
        self.wire.transport.close()

    def _demand(self, name: str, reason: int, times: int) -> None:
        self.stream.clear(self.clock.now())
        self._stop_wanted = (name, reason & 0xFF)
        for _ in range(times):
            self._send(name, reason=reason & 0xFF)

    def _exchange(self, guard: bool) -> list[Telemetry]:
        """One round of receiving and sending."""
        events: list[Telemetry] = []
        for frame in self.wire.receive():
            if not (self._handshake.take(frame.name, frame.fields) or self._take_clock(frame)):
                event = self._reader.read(frame.name, frame.fields, frame.time)
                if event is not None:
                    self._watch(event)
                    events.append(event)
        now = self.clock.now()
        if guard:
            self._check_silence(now)
        # First the clock's request, so that nothing of this round delays it on the wire.
        asked = self._ask_clock(now)
        if self._stop_wanted is not None:
            self._send(self._stop_wanted[0], reason=self._stop_wanted[1])
        if not asked:  # on a bus it would overtake the request
            self._keep_alive(now)
        self.stream.service(now)
        return events

    def _watch(self, event: Telemetry) -> None:
        if isinstance(event, MotionStatus):
            self.stream.on_status(event)
        elif isinstance(event, LinkQuality):
            self.quality = event
        elif isinstance(event, FirmwareState):
            before, self.state = self.state, event
            was_driveable = before is not None and before.state in DRIVEABLE
            if event.state not in DRIVEABLE:
                self._stop_wanted = None
            if was_driveable and event.state not in DRIVEABLE:
                self.stream.clear(event.time)
            if self.identity is not None and not event.handshake_done:
                raise SafetyStop("the firmware has restarted in mid-mission: its handshake with us is forgotten")

    def _take_clock(self, frame: Received) -> bool:
        if frame.name != "ClockReply":
            return False
        sent = self._clock_sent.pop(int(frame.fields["sequence"]), None)
        if sent is not None:
            times = self.wire.transport.wire_times(messages.ClockRequest.LENGTH, messages.ClockReply.LENGTH)
            receive_time, turnaround = (int(frame.fields[field]) for field in ("receive_time", "turnaround"))
            self.clock_estimate.add(sent, frame.time, receive_time, turnaround, *times)
            self.round_trips.append(self.clock_estimate.round_trip)
            if self.clock_estimate.count >= CLOCK_FAST_COUNT:
                self._clock_due = self.clock.now() + CLOCK_PERIOD_S
        return True

    def _keep_alive(self, now: float) -> None:
        if now < self._keep_alive_due - 1e-9:
            return
        self._keep_alive_counter = (self._keep_alive_counter + 1) & 0xFF
        self._send("KeepAlive", counter=self._keep_alive_counter)
        self._keep_alive_due = now + KEEP_ALIVE_PERIOD_S

    def _ask_clock(self, now: float) -> bool:
        if now < self._clock_due - 1e-9:
            return False
        self._clock_sequence = (self._clock_sequence + 1) & 0xFF
        self._send("ClockRequest", sequence=self._clock_sequence)
        self._clock_sent[self._clock_sequence] = self.clock.now() + self.wire.transport.lead
        while len(self._clock_sent) > 8:
            self._clock_sent.pop(next(iter(self._clock_sent)))
        fast = self.clock_estimate.count < CLOCK_FAST_COUNT
        self._clock_due = now + (CLOCK_PERIOD_FAST_S if fast else CLOCK_ANSWER_TIMEOUT_S)
        return True

    def _check_silence(self, now: float) -> None:
        heard = self.wire.last_heard
        since = max(heard if heard is not None else 0.0, self._silent_since or 0.0)
        looked, self._looked = self._looked, now
        if looked is not None and now - looked > STALL_S:
            # The host has stood still: what came meanwhile may still be on its way in. It counts as a short silence.
            since = self._silent_since = max(now - max(looked - since, 0.0) - STALL_S, since)
        if now - since > MAX_SILENCE_S:
            raise LinkLost(f"link lost: nothing from the firmware for {now - since:.1f} s")

    def _request(self, send: Callable[[], object], done: Callable[[Telemetry], bool], timeout: float) -> bool:
        """Repeats `send` every 100 ms until `done` is true of an event; False after `timeout`."""
        start = self.clock.now()
        due = start
        while (now := self.clock.now()) - start <= timeout:
            if now >= due - 1e-9:
                send()
                due = now + 0.1
            self.clock.advance(now + STEP_S)
            events = self._exchange(guard=True)
            self._keep(events)
            finished = False
            for event in events:
                finished = done(event) or finished
            if finished:
                return True
        return False

    def _parameter(self, identifier: int, timeout: float, send: Callable[[], object]) -> ParameterValue:
        answers: list[ParameterValue] = []

        def answered(event: Telemetry) -> bool:
            if isinstance(event, ParameterValue) and event.identifier == identifier:
                answers.append(event)
            return bool(answers)

        if not self._request(send, answered, timeout):
            raise PreflightFailed(f"the firmware does not answer for parameter {identifier}")
        return answers[0]

    def _wait_for_state(self, timeout: float) -> None:
        if self.state is None and not self._request(lambda: None, lambda _: self.state is not None, timeout):
            raise PreflightFailed("the firmware does not tell its state")

    def _keep(self, events: list[Telemetry]) -> None:
        """What comes while a request waits is handed out by the next poll."""
        self._backlog.extend(events)

    def _send(self, name: str, **raw: int) -> None:
        self.wire.send(name, self.clock.now(), **raw)

    def _arm_refusal(self, refused: bool) -> str:
        state = self.state
        if state is None:
            return "the firmware does not tell its state"
        reasons = []
        if state.emergency_input:
            reasons.append("the emergency-stop input is active")
        if "LowBattery" in state.faults:
            reasons.append("the battery is too low")
        if not state.handshake_done:
            reasons.append("it has not accepted the handshake")
        why = ", ".join(reasons) or ("it refused" if refused else "it has not answered")
        return f"the firmware does not arm: {why} (state {state.state}, last stop: {state.cause})"

    def _no_answer(self, timeout: float) -> str:
        port = self.wire.transport.port
        if self._handshake.busy is not None:
            return f"the firmware on {port} is {self._handshake.busy}; it is free once its motors are off"
        if self.wire.last_heard is None:
            return f"no answer on {port} within {timeout:g} s: is the rover powered and is this its port?"
        if self.wire.counters.frames == 0:
            return f"{port} sends bytes that are no frames of the rover's protocol: wrong port or baud rate?"
        return f"the firmware on {port} does not answer the handshake"
