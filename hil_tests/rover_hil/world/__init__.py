"""The world file: every way in which the simulated world can be unfriendly, each with a switch and a size."""

from rover_hil.world.file import World, load_world, world_of

__all__ = ["World", "load_world", "world_of"]
