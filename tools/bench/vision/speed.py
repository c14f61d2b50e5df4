"""One frame from counts to pose: processor time in all and stage by stage."""

from __future__ import annotations

import time

import numpy as np
from rover.vision.camera.file import load_camera
from rover.vision.localization.localizer import Localizer

from tools.bench.vision.drives import FRAME_STEPS, START_SIGMA, random_drive, scenes
from tools.bench.vision.way import STEP_M

STAGES = ("clean", "ground view", "contrast", "features", "match", "cluster", "pose", "filter", "keyframe")
LIMITS_MS = {"lepton-160": 5.0, "e6390-320": 10.0}


class StageClock:
    """Adds up the processor time of each stage of one frame."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = {}
        self._last = 0.0

    def start(self) -> None:
        """A frame begins."""
        self.spent = {}
        self._last = time.thread_time()

    def mark(self, stage: str) -> None:
        """A stage has ended."""
        now = time.thread_time()
        self.spent[stage] = self.spent.get(stage, 0.0) + now - self._last
        self._last = now


def speed_table(first: int, length: float) -> str:
    """Median and 99th percentile in ms of processor time, for both cameras."""
    rows = ["| | " + " | ".join(LIMITS_MS) + " |", "|---|" + "---|" * len(LIMITS_MS)]
    columns = [_measure(name, first, length) for name in LIMITS_MS]
    for stage in ("all", *STAGES):
        rows.append(f"| {stage} | " + " | ".join(column[stage] for column in columns) + " |")
    return "\n".join(rows)


def _measure(name: str, first: int, length: float) -> dict[str, str]:
    camera, clock = load_camera(name), StageClock()
    ((_, at),) = scenes(camera, 1, first)
    drive = random_drive(at, 0.05, length)
    localizer = Localizer(camera, drive.poses[0], START_SIGMA, mark=clock.mark)
    frames: list[dict[str, float]] = []
    for step in range(1, len(drive.poses)):
        localizer.predict(step * STEP_M, drive.left[step - 1], drive.right[step - 1])
        if step % FRAME_STEPS == 0:
            frame = at.frame(drive.poses[step], step)
            clock.start()
            localizer.observe(frame)
            frames.append(clock.spent)
    made = {stage: np.array([spent.get(stage, 0.0) for spent in frames]) * 1e3 for stage in STAGES}
    made["all"] = np.array([sum(spent.values()) for spent in frames]) * 1e3
    return {stage: f"{np.median(ms):.2f} (p99 {np.percentile(ms, 99):.2f})" for stage, ms in made.items()}
