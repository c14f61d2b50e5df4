"""The ground of a simulated mission: heat over the day, soil, rocks, grass and mines, or real thermal pictures."""

from rover_hil.ground.field import Ground, build
from rover_hil.ground.mine import Mine
from rover_hil.ground.signature import contrast_table, daily_contrasts, lay_signature, signature

__all__ = ["Ground", "Mine", "build", "contrast_table", "daily_contrasts", "lay_signature", "signature"]
