"""The hours at which the second look trusts a sign are those at which the simulated day has it."""

from __future__ import annotations

import numpy as np
import pytest
from rover.detection.second_look import sign_at
from rover_hil.ground import daily_contrasts

DEPTHS = (0.01, 0.02, 0.03, 0.05)


@pytest.mark.parametrize("soil", ["loam", "clay", "moist-clay"])
def test_no_mine_down_to_5_cm_has_the_other_sign_when_the_second_look_trusts_one(soil: str) -> None:
    day = daily_contrasts(soil, DEPTHS)
    for hour in np.arange(0.0, 24.0, 0.25).tolist():
        for depth in DEPTHS:
            contrast = float(day.profile(depth, hour, 0.0))
            assert sign_at(hour) == 0 or np.sign(contrast) == sign_at(hour) or abs(contrast) < 0.1, (hour, depth)
