"""Codes, sessions and the operator's seat."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rover.console.limits import MAX_BUCKETS, Limit
from rover.console.sessions import CODE_LENGTH, GONE_S, IDLE_S, Codes, Refused, Role, Sessions, new_code


@pytest.fixture
def codes() -> Codes:
    return Codes("ABCDEFGH", "HGFEDCBA")


@pytest.fixture
def sessions(codes: Codes) -> Sessions:
    return Sessions(codes)


def test_a_code_is_taken_as_people_type_it(sessions: Sessions) -> None:
    assert sessions.pair(" abcd-efgh ", "Ada  Lovelace\n", "here", 0.0).name == "Ada Lovelace"
    assert sessions.pair("hgfedcba", "", "here", 0.0).role is Role.VIEWER


def test_codes_are_not_repeated() -> None:
    assert len({new_code() for _ in range(200)}) == 200
    assert len(new_code()) == CODE_LENGTH


def test_one_at_a_time_has_the_seat_and_hands_it_over(sessions: Sessions) -> None:
    ada, bob = (sessions.pair("ABCDEFGH", name, name, 0.0) for name in ("Ada", "Bob"))
    ada.connections = bob.connections = 1
    assert sessions.take_seat(ada, 0.0)
    assert not sessions.take_seat(bob, 0.0)
    assert [each["asks"] for each in sessions.document(ada)["people"]] == [False, True]
    with pytest.raises(Refused, match="Ada has the seat"):
        sessions.operates(bob)
    assert sessions.hand_over(ada, bob.number) is bob
    sessions.operates(bob)
    with pytest.raises(Refused):
        sessions.operates(ada)


def test_a_viewer_never_gets_the_seat(sessions: Sessions) -> None:
    ada = sessions.pair("ABCDEFGH", "Ada", "a", 0.0)
    eve = sessions.pair("HGFEDCBA", "Eve", "b", 0.0)
    with pytest.raises(Refused, match="only look on"):
        sessions.take_seat(eve, 0.0)
    sessions.take_seat(ada, 0.0)
    with pytest.raises(Refused):
        sessions.hand_over(ada, eve.number)


def test_a_lost_browser_keeps_the_seat_for_a_while_and_no_longer(sessions: Sessions) -> None:
    ada, bob = (sessions.pair("ABCDEFGH", name, name, 0.0) for name in ("Ada", "Bob"))
    sessions.take_seat(ada, 0.0)
    assert not sessions.take_seat(bob, GONE_S - 1.0)
    assert sessions.take_seat(bob, GONE_S + 1.0)


def test_a_session_ends_when_nobody_uses_it(sessions: Sessions) -> None:
    ada = sessions.pair("ABCDEFGH", "Ada", "a", 0.0)
    assert sessions.find(ada.token, IDLE_S - 1.0) is ada
    with pytest.raises(Refused):
        sessions.find(ada.token, 2.1 * IDLE_S)


def test_who_leaves_leaves_the_seat(sessions: Sessions) -> None:
    ada = sessions.pair("ABCDEFGH", "Ada", "a", 0.0)
    sessions.take_seat(ada, 0.0)
    sessions.leave(ada)
    assert sessions.document(sessions.pair("ABCDEFGH", "Bob", "b", 0.0))["operator"] is None
    with pytest.raises(Refused):
        sessions.find(ada.token, 0.0)


@given(st.lists(st.floats(0.0, 5.0), min_size=1, max_size=200))
def test_no_more_is_allowed_than_rate_and_burst(gaps: list[float]) -> None:
    limit, now, allowed = Limit(2.0, 5.0), 0.0, 0
    for gap in gaps:
        now += gap
        allowed += limit.allows("somebody", now)
    assert allowed <= 5.0 + 2.0 * (now - gaps[0]) + 1e-6


def test_many_names_take_no_more_room() -> None:
    limit = Limit(1.0, 1.0)
    for number in range(3 * MAX_BUCKETS):
        limit.allows(str(number), 0.0)
    assert len(limit._buckets) <= MAX_BUCKETS
