"""PI gains of the speed loop for a drive of first order with a delay, and the margins that result.

duty → speed is 1 / (a s + k) · e^(-θ s). With λ tuning (internal model control) the gain is a / (λ + θ), and the
integral's time is that of the drive, or four times λ + θ where the drive is slower than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rover.bringup.feed_forward import FeedForward

# Observer, tick and bridge: from a speed to the duty that answers it, seconds.
DELAY_S = 0.010
# Time constant of the closed loop, seconds.
LAMBDA_S = 0.012


@dataclass(frozen=True)
class Gains:
    """Duty for 1 m/s of error and for 1 m of its integral; margins: phase (degrees), gain (factor), delay (seconds)."""

    velocity: float
    integral: float
    phase_margin_deg: float
    gain_margin: float
    delay_margin_s: float


def tuned(drive: FeedForward) -> Gains:
    """For that drive."""
    reach = LAMBDA_S + DELAY_S
    a, k = max(drive.acceleration, 1e-4), drive.velocity
    velocity = a / reach
    integral = velocity / max(a / k, 4.0 * reach)
    return Gains(velocity, integral, *margins(velocity, integral, a, k))


def margins(velocity: float, integral: float, a: float, k: float) -> tuple[float, float, float]:
    """Phase margin (degrees), gain margin and delay margin (seconds) of the open loop."""
    frequency = np.geomspace(0.1, 1000.0, 20_000)  # rad/s
    s = 1j * frequency
    loop = (velocity + integral / s) / (a * s + k) * np.exp(-DELAY_S * s)
    size, phase = np.abs(loop), np.unwrap(np.angle(loop))
    crossing = int(np.argmax(size < 1.0))
    phase_margin = float(np.pi + phase[crossing])
    reversal = int(np.argmax(phase < -np.pi))
    gain_margin = float(1.0 / size[reversal]) if reversal else float("inf")
    return float(np.degrees(phase_margin)), gain_margin, phase_margin / float(frequency[crossing])
