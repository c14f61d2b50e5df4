"""Names of the topics of a log that its readers look for, and which of them are inputs."""

from __future__ import annotations

CAMERA_THERMAL = "/camera/thermal"
CAMERA_FRAME = "/camera/frame"
"""Number, exposure and shutter of the picture that follows it."""
RIG_STEP = "/rig/step"
RIG_CYCLE = "/rig/cycle"
"""What came over the wire of a real rover; layout: see rover.record.device_cycle."""
CAMERA_LOST = "/camera/lost"
"""Why no more pictures came from a real camera."""
RIG_LOST = "/rig/lost"
OPERATOR = "/operator"
LINK_RECEIVED = "/link/rx"
LINK_SENT = "/link/tx"
SEGMENTS = "/motion/segments"
PLACES = "/detection/places"
FIX = "/localization/fix"
POSE = "/pose"

VERDICT_ASKED = "/referee/asked"
"""Zones as they were, version by version, and what was reported: all that a referee needs besides the truth."""

IMPORTED_WHEELS = "/import/wheels"
IMPORTED_SONAR = "/import/sonar"

FED = frozenset(
    (
        *(CAMERA_THERMAL, CAMERA_FRAME, CAMERA_LOST),
        *(RIG_STEP, RIG_CYCLE, RIG_LOST, OPERATOR, VERDICT_ASKED),
        *(IMPORTED_WHEELS, IMPORTED_SONAR),
    )
)
"""Inputs that a replay takes from the log, and what lies behind its end: not compared."""
