"""What a thermal camera does that its calibration file does not say."""

from __future__ import annotations

from collections.abc import Mapping

from rover_hil.world.effect import Effect, Size

LEPTON = "Lepton Engineering Datasheet 500-0659-00-09"
NATURE = "1: the sizes are standard deviations, drawn from the seed; 0: exactly these"

CAMERA: Mapping[str, Effect] = {
    "mount": Effect(
        "the camera sits otherwise than its file says",
        "assumed: a bracket of 40 mm whose screws have 0.5 mm of play tilts by 0.7 degrees",
        {
            "roll_deg": Size(0.4, -10, 10, "about the direction of travel"),
            "pitch_deg": Size(0.5, -10, 10, "down"),
            "yaw_deg": Size(0.4, -10, 10, "to the left"),
            "height_m": Size(0.005, -0.1, 0.1, "above what the file says"),
            "drawn": Size(1, 0, 1, NATURE),
        },
    ),
    "lens": Effect(
        "the lens bends otherwise than its calibration says (added to the file's coefficients)",
        "assumed: what two calibrations of one 57-degree lens differ by; -0.15 is a lens that was never calibrated",
        {
            "k1": Size(-0.02, -0.5, 0.5, "Brown-Conrady"),
            "k2": Size(0.0, -0.5, 0.5, "Brown-Conrady"),
        },
    ),
    "blur": Effect(
        "pixels follow the scene with a time constant: what moves is smeared",
        "vanadium oxide microbolometers have 7 to 15 ms (Rogalski, Infrared Detectors, 2nd ed., chapter 6)",
        {"time_constant_ms": Size(12, 0, 100, "of a pixel")},
    ),
    "delivery": Effect(
        "pictures come late, twice or never; none overtakes another",
        "assumed: USB video on a busy single-board computer",
        {
            "jitter_ms": Size(8, 0, 500, "mean of what comes on top of the latency, exponential"),
            "dropped": Size(0.02, 0, 1, "share that never comes"),
            "repeated": Size(0.01, 0, 1, "share that comes twice"),
            "late": Size(0.01, 0, 1, "share that is held up"),
            "late_ms": Size(300, 0, 5000, "for so long"),
        },
    ),
    "clock": Effect(
        "pictures are stamped by the camera's own clock",
        "crystals of consumer boards: up to 50 ppm; the offset is assumed: stamps at arrival, latency guessed",
        {
            "offset_ms": Size(5, -200, 200, "fast at the start"),
            "drift_ppm": Size(30, -1000, 1000, "fast"),
        },
    ),
    "drift": Effect(
        "between calibrations the level wanders, over all and from edge to edge",
        f"{LEPTON}: radiometric accuracy of 5 degrees, a calibration every 3 minutes or 1.5 degrees; time assumed",
        {
            "level_k": Size(0.5, 0, 20, "standard deviation"),
            "slope_k": Size(0.2, 0, 10, "standard deviation, from edge to edge"),
            "time_constant_s": Size(60, 0.1, 3600, "of both"),
        },
    ),
    "shutter": Effect(
        "the shutter closes when the rover turns: the sensor has warmed up just then",
        f"{LEPTON}: a shutter event lasts about 1 s; that it comes while turning is the worst case, not a measurement",
        {
            "turning_rad_s": Size(0.5, 0.01, 10, "from this rate on"),
            "lasts_s": Size(1.0, 0.1, 20, "closed"),
            "rest_s": Size(60, 0, 3600, "until it may close again"),
        },
    ),
    "dirt": Effect(
        "dust sticks to the window, drops land on it and dry",
        "assumed: a window of 8 mm with grains of 0.3 mm, out of focus",
        {
            "spots": Size(3, 0, 200, "from the start"),
            "drops_per_min": Size(0.5, 0, 600, "that land"),
            "drop_lasts_s": Size(20, 0.1, 3600, "until dry"),
            "radius_px": Size(5, 0.5, 60, "of one, half to one and a half times that"),
            "transmission": Size(0.7, 0, 1, "of its middle"),
            "window_k": Size(296, 250, 350, "its temperature"),
        },
    ),
    "glints": Effect(
        "wet or bare metal throws the sun into the lens for a moment",
        "assumed: emissivity 0.1 metal mirrors 90 % of what it faces; the sun fills a small part of a pixel",
        {
            "per_min": Size(2, 0, 600, "how often"),
            "strength_k": Size(15, 0, 200, "at most"),
            "lasts_s": Size(0.3, 0.01, 10, "each"),
        },
    ),
}
