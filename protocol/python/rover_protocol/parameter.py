"""What is known of one of the firmware's parameters; runs on MicroPython, too."""


class Parameter:
    """name, unit, identifier on the wire; default and range; help in a line.

    start_minimum, start_maximum: within which a rover may set off. safety: a wrong value may let it hurt somebody.
    """

    def __init__(
        self,
        name: str,
        unit: str,
        identifier: int,
        default: int,
        minimum: int,
        maximum: int,
        start_minimum: int,
        start_maximum: int,
        safety: bool,
        help: str,
    ) -> None:
        self.name = name
        self.unit = unit
        self.identifier = identifier
        self.default = default
        self.minimum = minimum
        self.maximum = maximum
        self.start_minimum = start_minimum
        self.start_maximum = start_maximum
        self.safety = safety
        self.help = help
