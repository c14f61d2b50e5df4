"""Every effect of a world file, by "group.name"."""

from __future__ import annotations

from collections.abc import Mapping

from rover_hil.world.camera_effects import CAMERA
from rover_hil.world.effect import Effect
from rover_hil.world.ground_effects import GROUND, WEATHER
from rover_hil.world.thing_effects import THINGS

GROUPS: Mapping[str, Mapping[str, Effect]] = {"camera": CAMERA, "ground": GROUND, "weather": WEATHER, "things": THINGS}

EFFECTS: Mapping[str, Effect] = {
    f"{group}.{name}": effect for group, effects in GROUPS.items() for name, effect in effects.items()
}
