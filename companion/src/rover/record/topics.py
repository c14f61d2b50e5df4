"""Names of the topics of a log that its readers look for, and which of them are inputs."""

from __future__ import annotations

CAMERA_THERMAL = "/camera/thermal"
# Number, exposure and shutter of the picture that follows it.
CAMERA_FRAME = "/camera/frame"
RIG_STEP = "/rig/step"
# What came over the wire of a real rover; layout: see rover.record.device_cycle.
RIG_CYCLE = "/rig/cycle"
# Why no more pictures came from a real camera.
CAMERA_LOST = "/camera/lost"
RIG_LOST = "/rig/lost"
OPERATOR = "/operator"
LINK_RECEIVED = "/link/rx"
LINK_SENT = "/link/tx"
SEGMENTS = "/motion/segments"
PLACES = "/detection/places"
FIX = "/localization/fix"
POSE = "/pose"
GRID = "/map/grid"

# Zones as they were, version by version, and what was reported: all that a referee needs besides the truth.
VERDICT_ASKED = "/referee/asked"

IMPORTED_WHEELS = "/import/wheels"
IMPORTED_SONAR = "/import/sonar"

# Inputs that a replay takes from the log, and what lies behind its end: not compared.
FED = frozenset(
    (
        *(CAMERA_THERMAL, CAMERA_FRAME, CAMERA_LOST),
        *(RIG_STEP, RIG_CYCLE, RIG_LOST, OPERATOR, VERDICT_ASKED),
        *(IMPORTED_WHEELS, IMPORTED_SONAR),
    )
)
