"""What buried mines do to the ground's temperature hour by hour, typically: when to expect to see any.

For a site of its own soil, season and weather `rover when` asks the heat model itself; what is here is one clear day in
June over loam, for when nobody has asked it.
"""

from __future__ import annotations

import numpy as np

# Contrast of a mine on the ground and of mines 1, 3 and 5 cm deep in loam on a clear day at each full hour, kelvin
# (`rover_hil.ground.daily_contrasts("loam", (0.0, 0.01, 0.03, 0.05))`).
TYPICAL_K = (
    (-3.36, -3.29, -3.15, -2.91, -2.60, -2.21, -1.78, 0.65, 2.70, 4.14, 4.99, 5.27,
     5.03, 4.33, 3.23, 1.81, 0.16, -1.66, -3.53, -3.37, -3.27, -3.27, -3.32, -3.36),
    (-2.38, -2.36, -2.29, -2.17, -2.00, -1.78, -1.53, -0.19, 1.42, 2.73, 3.65, 4.14,
     4.22, 3.91, 3.26, 2.30, 1.11, -0.27, -1.75, -2.19, -2.23, -2.26, -2.31, -2.36),
    (-1.14, -1.16, -1.15, -1.12, -1.06, -0.98, -0.87, -0.51, 0.15, 0.82, 1.37, 1.75,
     1.95, 1.96, 1.79, 1.45, 0.98, 0.39, -0.28, -0.76, -0.92, -1.00, -1.06, -1.11),
    (-0.57, -0.59, -0.60, -0.60, -0.59, -0.56, -0.52, -0.42, -0.17, 0.15, 0.45, 0.70,
     0.88, 0.96, 0.96, 0.86, 0.69, 0.45, 0.14, -0.15, -0.33, -0.42, -0.48, -0.53),
)  # fmt: skip
# Of a mine 3 cm deep: below the first hardly any is seen, from the second on the hour is a good one, kelvin.
HARDLY_K, GOOD_K = 0.5, 1.0
STEP_HOURS = 0.5


def typical(hour: float) -> tuple[float, ...]:
    """Contrast at an hour (0 to 24) of mines on the ground and 1, 3 and 5 cm deep, kelvin."""
    full = np.arange(25.0)
    return tuple(float(np.interp(hour % 24.0, full, (*day, day[0]))) for day in TYPICAL_K)


def warning(hour: float) -> str:
    """What to tell who surveys at an hour at which hardly any contrast is expected; "" at any other."""
    _, _, at_3, at_5 = typical(hour)
    if abs(at_3) >= HARDLY_K:
        return ""
    ahead = np.arange(1, round(24.0 / STEP_HOURS)) * STEP_HOURS
    later = (np.floor(hour / STEP_HOURS) * STEP_HOURS + ahead) % 24.0
    good = next(float(each) for each in later if abs(typical(float(each))[2]) >= GOOD_K)
    return (
        f"at {_clock(hour)} hardly any contrast is expected: mines 3 cm deep in loam differ by {at_3:+.1f} K, 5 cm by "
        f"{at_5:+.1f} K; the next good hour is {_clock(good)}, see rover when"
    )


def _clock(hour: float) -> str:
    minutes = round(60.0 * hour) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d}"
