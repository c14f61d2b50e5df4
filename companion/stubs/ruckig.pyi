"""What rover.motion uses of ruckig, which ships no types."""

import enum

class RuckigError(Exception): ...

class Result(enum.IntEnum):
    Working = 0
    Finished = 1
    Error = -1

class ControlInterface(enum.Enum):
    Position = 0
    Velocity = 1

class InputParameter:
    def __init__(self, degrees_of_freedom: int) -> None: ...
    control_interface: ControlInterface
    current_position: list[float]
    current_velocity: list[float]
    current_acceleration: list[float]
    target_position: list[float]
    target_velocity: list[float]
    target_acceleration: list[float]
    max_velocity: list[float]
    max_acceleration: list[float]
    max_jerk: list[float]

class BrakeProfile:
    t: list[float]
    j: list[float]

class Profile:
    t: list[float]
    j: list[float]
    brake: BrakeProfile
    accel: BrakeProfile

class Extrema:
    min: float
    max: float

class Trajectory:
    def __init__(self, degrees_of_freedom: int) -> None: ...
    profiles: list[list[Profile]]
    position_extrema: list[Extrema]

class Ruckig:
    def __init__(self, degrees_of_freedom: int) -> None: ...
    def calculate(self, input: InputParameter, trajectory: Trajectory) -> Result: ...
