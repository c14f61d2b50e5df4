"""The firmware's parameters by name, without a link: what exists, and which values it may have."""

from __future__ import annotations

import difflib

from rover_protocol.parameter import Parameter
from rover_protocol.parameters import BY_NAME

from rover.errors import BadInput


def named(name: str) -> Parameter:
    """The parameter of that name. Raises BadInput."""
    known = BY_NAME.get(name)
    if known is None:
        near = difflib.get_close_matches(name, BY_NAME, n=1)
        hint = f"; did you mean {near[0]}?" if near else f"; there is {', '.join(BY_NAME)}"
        raise BadInput(f"{name}: no such parameter{hint}")
    return known


def checked(name: str, value: int) -> int:
    """The value, which lies in the parameter's range. Raises BadInput."""
    known = named(name)
    if not known.minimum <= value <= known.maximum:
        raise BadInput(f"{name}: {value} lies outside {known.minimum} to {known.maximum} {known.unit}")
    return value
