"""What the ground and the sky above it do."""

from __future__ import annotations

from collections.abc import Mapping

from rover_hil.world.effect import Effect, Size

GROUND: Mapping[str, Effect] = {
    "clutter": Effect(
        "soil differs from place to place, so that its pattern changes over the day; in place of the even texture",
        "spectrum: real clay soil (see ground/clutter.py). Sizes: at 13:00 together the 0.4 K of the even texture",
        {
            "albedo": Size(0.01, 0, 0.2, "standard deviation"),
            "moisture": Size(0.003, 0, 0.1, "standard deviation, share of the volume"),
            "conductivity": Size(0.04, 0, 0.4, "standard deviation, share"),
            "heat_capacity": Size(0.02, 0, 0.2, "standard deviation, share"),
            "roughness": Size(0.02, 0, 0.4, "standard deviation of the exchange with the air, share"),
            "vegetation": Size(0.005, 0, 0.5, "share of the ground under single blades"),
        },
    ),
    "tilt": Effect(
        "uneven ground tilts the rover with its camera: what it sees of the ground shifts",
        "assumed: wheels 20 cm apart on soil of 5 mm rms tilt by 2 degrees; 15 degrees is the steepest that it climbs",
        {
            "tilt_deg": Size(1.0, 0, 15, "root mean square"),
            "length_m": Size(0.7, 0.1, 20, "of the waves, m"),
        },
    ),
    "slip": Effect(
        "loose or wet patches: a wheel loses its grip for a moment",
        "a wheel on loose sand slips by 0.2 to 0.6 (Wong, Theory of Ground Vehicles, chapter 2); how often is assumed",
        {
            "per_metre": Size(0.1, 0, 20, "bursts of a wheel for each metre that it rolls"),
            "share": Size(0.3, 0, 1, "of the wheel's travel that is lost, at most"),
            "lasts_m": Size(0.08, 0.005, 2, "mean way of a burst"),
        },
    ),
}

WEATHER: Mapping[str, Effect] = {
    "clouds": Effect(
        "clouds pass before the sun; ground cools and warms by its thermal inertia",
        "cumulus take 60 to 80 % of the sun for minutes (Kasten and Czeplak, Solar Energy 24, 1980)",
        {
            "cover": Size(0.2, 0, 1, "share of the time under one"),
            "depth": Size(0.6, 0, 1, "share of the sun that one takes"),
            "period_s": Size(180, 5, 3600, "from one to the next"),
        },
    ),
    "wind": Effect(
        "gusts cool what is warmer than the air",
        "turbulence intensity near the ground is 0.2 to 0.4 (Stull, Boundary Layer Meteorology, chapter 2)",
        {
            "gusts": Size(0.2, 0, 1, "standard deviation of the exchange with the air, share"),
            "time_constant_s": Size(20, 1, 600, "of a gust"),
        },
    ),
    "shadows": Effect(
        "shadows of trees beyond the border wander over the field with the sun",
        "geometry and the heat of the half space; how many and how tall is assumed",
        {
            "trees": Size(1, 0, 30, "how many"),
            "height_m": Size(4, 0.5, 30, "tall, 0.6 to 1.4 times that"),
        },
    ),
    "dew": Effect(
        "a film of water from two hours before sunrise, which evens out the ground and dries in patches",
        "assumed; evaporation cools by about 1.5 K until it is dry",
        {"wetness": Size(0.4, 0, 1, "share of the contrast that it takes")},
    ),
}
