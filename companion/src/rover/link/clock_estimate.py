"""What the firmware's clock shows, estimated from request and reply.

Each exchange gives one sample of the offset: with the wire's own time known, half of what is left of the round trip
lies on either side. The samples with the shortest round trips are the least delayed ones; a line through them gives
offset and drift. After Cristian (1989), with the gating of NTP's clock filter.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from rover.link.unwrap import unwrap

WINDOW = 128
"""Samples kept: 64 s at two a second."""

MINIMUM_SPAN = 4.0
"""Seconds that the window must span before a drift is fitted; before that the drift is taken as zero."""

MINIMUM_SAMPLES = 8

ROUND_TRIP_SLACK = 0.0005
"""Seconds above the shortest round trip within which a sample still counts as undelayed."""


@dataclass(frozen=True)
class Sample:
    """One exchange in seconds: companion time, unwrapped firmware time then, round trip less the wire's own time."""

    time: float
    firmware: float
    excess: float


@dataclass(frozen=True)
class ClockFit:
    """firmware = time + offset + drift * (time - origin), good to about `error_bound` seconds."""

    origin: float
    offset: float
    drift: float
    error_bound: float


def fit_clock(samples: list[Sample], time_step: float = 0.0) -> ClockFit:
    """Offset and drift through the least delayed samples; `samples` must not be empty.

    `time_step`: seconds to which the times are rounded; both ends of an exchange may be off by half of it, the same
    way each time, so no number of samples averages it out.
    """
    shortest = min(sample.excess for sample in samples)
    chosen = [sample for sample in samples if sample.excess <= shortest + ROUND_TRIP_SLACK]
    fit = _line(chosen)
    residuals = [abs(_residual(fit, sample)) for sample in chosen]
    gate = 3.0 * max(sorted(residuals)[len(residuals) // 2], 20e-6)
    kept = [sample for sample, residual in zip(chosen, residuals, strict=True) if residual <= gate]
    if len(kept) < len(chosen):
        fit = _line(kept)
    spread = math.sqrt(sum(_residual(fit, sample) ** 2 for sample in kept) / len(kept))
    bound = time_step + 0.5 * shortest + spread / math.sqrt(len(kept)) + 0.5e-6
    return ClockFit(fit.origin, fit.offset, fit.drift, bound)


class ClockEstimate:
    """Collects exchanges and converts between companion time (s) and firmware time (µs, unwrapped)."""

    def __init__(self, byte_time: float = 10.0 / 230_400.0, time_step: float = 0.0) -> None:
        """`byte_time`: seconds that one byte takes on the wire, 0 where it travels at once (USB, pty without rig).

        `time_step`: see `fit_clock`. A firmware that runs in such steps takes a request at the end of the step in
        which it arrived, and all that it answers is out at that same moment, as far as the step has room for it.
        """
        self.byte_time = byte_time
        self.time_step = time_step
        self.count = 0
        self.round_trip = math.inf
        self._samples: deque[Sample] = deque(maxlen=WINDOW)
        self._fit: ClockFit | None = None

    @property
    def ready(self) -> bool:
        """True after the first exchange."""
        return self._fit is not None

    @property
    def error_bound(self) -> float:
        """Seconds; infinite before the first exchange."""
        return math.inf if self._fit is None else self._fit.error_bound

    @property
    def drift(self) -> float:
        """Seconds that the firmware gains per second of companion time."""
        return 0.0 if self._fit is None else self._fit.drift

    def add(
        self, sent: float, received: float, receive_time_us: int, turnaround_us: int, up_bytes: float, down_bytes: float
    ) -> None:
        """One exchange: companion times of the request and the reply, and what the reply says (raw 32-bit µs)."""
        round_trip = received - sent
        wire_up, wire_down = up_bytes * self.byte_time, down_bytes * self.byte_time
        if self.time_step:
            wire_up = math.ceil(wire_up / self.time_step) * self.time_step
            wire_down = math.floor(wire_down / self.time_step) * self.time_step
        excess = max(0.0, round_trip - turnaround_us * 1e-6 - wire_up - wire_down)
        at = sent + wire_up + 0.5 * excess
        near = self.to_firmware(at) if self._fit is not None else receive_time_us
        firmware_us = unwrap(receive_time_us, 32, near)
        self._samples.append(Sample(at, firmware_us * 1e-6, excess))
        self._fit = fit_clock(list(self._samples), self.time_step)
        self.round_trip = round_trip
        self.count += 1

    def to_firmware(self, time: float) -> int:
        """Firmware time in µs, unwrapped (take it modulo 2**32 for the wire). Before an exchange: the same time."""
        if self._fit is None:
            return round(time * 1e6)
        fit = self._fit
        return round((time + fit.offset + fit.drift * (time - fit.origin)) * 1e6)

    def to_companion(self, firmware_us: int) -> float:
        """Companion time in seconds of an unwrapped firmware time in µs."""
        seconds = firmware_us * 1e-6
        if self._fit is None:
            return seconds
        fit = self._fit
        return fit.origin + (seconds - fit.offset - fit.origin) / (1.0 + fit.drift)

    def stamp(self, raw: int, received: float, unit_us: int = 1, bits: int = 32) -> float:
        """Companion time of a wrapping firmware stamp that was received at companion time `received`."""
        near = self.to_firmware(received) // unit_us
        return self.to_companion(unwrap(raw, bits, near) * unit_us)


def _line(samples: list[Sample]) -> ClockFit:
    times = [sample.time for sample in samples]
    origin = sum(times) / len(times)
    offset = sum(sample.firmware - sample.time for sample in samples) / len(samples)
    drift = 0.0
    if len(samples) >= MINIMUM_SAMPLES and max(times) - min(times) >= MINIMUM_SPAN:
        square = sum((t - origin) ** 2 for t in times)
        drift = sum((s.time - origin) * (s.firmware - s.time - offset) for s in samples) / square
    return ClockFit(origin, offset, drift, math.inf)


def _residual(fit: ClockFit, sample: Sample) -> float:
    return sample.firmware - sample.time - fit.offset - fit.drift * (sample.time - fit.origin)
