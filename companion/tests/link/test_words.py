"""The names that code acts on are those of rover.dbc, all of them and no others."""

from __future__ import annotations

import pytest
from rover.link.words import FaultCode, MotorState, SonarStatus, StopCause
from rover.str_enum import StrEnum
from rover_protocol import messages


@pytest.mark.parametrize(
    ("words", "names"),
    [
        (MotorState, messages.STATE_NAMES),
        (StopCause, messages.STATE_CAUSE_NAMES),
        (FaultCode, messages.FAULT_CODE_NAMES),
        (SonarStatus, messages.SONAR_STATUS_NAMES),
    ],
)
def test_the_words_are_those_of_the_wire_in_its_order(words: type[StrEnum], names: dict[int, str]) -> None:
    assert [word.value for word in words] == [names[number] for number in sorted(names)]
