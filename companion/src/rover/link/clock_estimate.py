"""What the firmware's clock shows, estimated from request and reply.

Each exchange gives one sample of the offset: with the wire's own time known, half of what is left of the round trip
lies on either side. The shorter the round trip, the less the sample was delayed, and the more it counts in the line
that gives offset and drift. After Cristian (1989), with weights in place of a choice of the best.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from rover.link.unwrap import unwrap

# Samples kept: 64 s at two a second.
MAX_SAMPLES = 128

# Seconds of error that even a sample without delay may have: what stamping it costs at both ends.
MIN_ERROR_S = 20e-6

# Samples above the shortest that show how far short round trips scatter.
SCATTER_SAMPLES = 4

# Seconds per second by which two crystals commonly differ: what is believed of the drift until samples show it.
DRIFT_SIGMA = 50e-6


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
    """Offset and drift, each sample weighted by how little it was delayed; `samples` must not be empty.

    `time_step`: seconds to which the times are rounded; both ends of an exchange may be off by half of it, the same
    way each time, so no number of samples averages it out.
    """
    excesses = sorted(sample.excess for sample in samples)
    shortest = excesses[0]
    # A delay d that is spread at random over both ways puts a sample off by d / sqrt(12). What all samples have in
    # common cannot be told from the way itself; how far the shortest few lie apart tells how well it is known.
    steadiest = MIN_ERROR_S + (excesses[min(SCATTER_SAMPLES, len(excesses) - 1)] - shortest) / math.sqrt(12.0)
    weights = [1.0 / (steadiest + (sample.excess - shortest) / math.sqrt(12.0)) ** 2 for sample in samples]
    total = sum(weights)
    origin = sum(w * s.time for w, s in zip(weights, samples, strict=True)) / total
    offset = sum(w * (s.firmware - s.time) for w, s in zip(weights, samples, strict=True)) / total
    square = sum(w * (s.time - origin) ** 2 for w, s in zip(weights, samples, strict=True))
    slope = sum(w * (s.time - origin) * (s.firmware - s.time - offset) for w, s in zip(weights, samples, strict=True))
    drift = slope / (square + 1.0 / DRIFT_SIGMA**2)
    bound = time_step + 0.5 * shortest + 2.0 / math.sqrt(total) + 0.5e-6
    return ClockFit(origin, offset, drift, bound)


class ClockEstimate:
    """Collects exchanges and converts between companion time (s) and firmware time (µs, unwrapped)."""

    def __init__(self, time_step: float = 0.0) -> None:
        """`time_step`: see `fit_clock`."""
        self.time_step = time_step
        self.count = 0
        self.round_trip = math.inf
        self._samples: deque[Sample] = deque(maxlen=MAX_SAMPLES)
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
        self, sent: float, received: float, receive_time_us: int, turnaround_us: int, wire_up: float, wire_down: float
    ) -> None:
        """One exchange: companion times of the request and the reply, and what the reply says (raw 32-bit µs).

        `wire_up`, `wire_down`: seconds that request and reply take without any delay.
        """
        round_trip = received - sent
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
        """Companion time of a wrapping firmware stamp that was received at companion time `received`.

        On a rig that runs in steps the nearest one: the firmware's ticks lie on them, whatever the estimate says.
        Before the first exchange nobody knows what the firmware's clock shows: `received` is the best there is.
        """
        if self._fit is None:
            return received
        near = self.to_firmware(received) // unit_us
        time = self.to_companion(unwrap(raw, bits, near) * unit_us)
        return round(time / self.time_step) * self.time_step if self.time_step else time
