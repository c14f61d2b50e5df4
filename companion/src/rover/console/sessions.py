"""Who looks on and who operates: pairing codes become sessions, and one of these at a time has the operator's seat.

Two codes are made at each start of the console. Whoever has the first may take the seat; the second is for looking on
only. The seat is handed over by who has it, or taken when it is free or its holder has been gone for GONE_S. The
emergency stop needs a session of the first code and no seat.
"""

from __future__ import annotations

import hmac
import secrets
from dataclasses import dataclass, field
from typing import Any

from rover.console.limits import Limit
from rover.str_enum import StrEnum

# Without letters and digits that are mistaken for each other: 30 symbols, 8 of them are 39 bits.
SYMBOLS = "ABCDEFGHJKMNPQRSTVWXYZ23456789"
CODE_LENGTH = 8
MAX_SESSIONS = 100
MAX_NAME = 40
IDLE_S = 12 * 3600.0
# A holder without a connection for so long has left the seat to others.
GONE_S = 20.0
# Wrong codes: from one address, and from all together.
TRIES = (1.0 / 12.0, 5.0)
ALL_TRIES = (0.5, 30.0)


class Role(StrEnum):
    """What a session may become."""

    VIEWER = "viewer"
    OPERATOR = "operator"


class Refused(Exception):
    """Not allowed; one line for the person who asked, and the status of HTTP."""

    def __init__(self, message: str, status: int = 403) -> None:
        super().__init__(message)
        self.status = status


@dataclass(eq=False)
class Session:
    """number: what others may know it by. connections: live ones. seen: when it was heard last, seconds."""

    token: str
    number: int
    name: str
    role: Role
    seen: float
    connections: int = 0
    asks_for_seat: bool = False


@dataclass
class Codes:
    """The pairing codes of one run of the console."""

    operator: str = field(default_factory=lambda: new_code())
    viewer: str = field(default_factory=lambda: new_code())


def new_code() -> str:
    """A code that nobody guesses within the tries that there are."""
    return "".join(secrets.choice(SYMBOLS) for _ in range(CODE_LENGTH))


class Sessions:
    """All of one console. Times are seconds of a monotonic clock."""

    def __init__(self, codes: Codes) -> None:
        self._codes = codes
        self._sessions: dict[str, Session] = {}
        self._made = 0
        self._seat: Session | None = None
        self._tries = Limit(*TRIES)
        self._all_tries = Limit(*ALL_TRIES)

    def pair(self, code: str, name: str, address: str, now: float) -> Session:
        """A new session. Raises Refused for a wrong code, and after too many of them for any."""
        if not (self._tries.allows(address, now) and self._all_tries.allows("", now)):
            raise Refused("too many tries; wait a minute", 429)
        given = code.strip().upper().replace("-", "").replace(" ", "").encode()
        role = None
        for known, meant in ((self._codes.operator, Role.OPERATOR), (self._codes.viewer, Role.VIEWER)):
            if hmac.compare_digest(given, known.encode()):
                role = meant
        if role is None:
            raise Refused("this is not the pairing code; it stands on the first line that rover console printed")
        self._forget(now)
        if len(self._sessions) >= MAX_SESSIONS:
            raise Refused("too many sessions", 429)
        self._made += 1
        shown = " ".join(name.split())[:MAX_NAME] or f"{role} {self._made}"
        session = Session(secrets.token_urlsafe(32), self._made, shown, role, now)
        self._sessions[session.token] = session
        return session

    def find(self, token: str | None, now: float) -> Session:
        """The session of a token. Raises Refused."""
        session = self._sessions.get(token or "")
        if session is None or (session.connections == 0 and now - session.seen > IDLE_S):
            raise Refused("pair this browser first", 401)
        session.seen = now
        return session

    def known(self, token: str) -> bool:
        """True for the token of a session."""
        return token in self._sessions

    def leave(self, session: Session) -> None:
        """Its token is worth nothing from now on."""
        self._sessions.pop(session.token, None)
        if self._seat is session:
            self._seat = None

    def operates(self, session: Session) -> None:
        """Raises Refused for a session without the seat."""
        self.may_operate(session)
        if self._seat is not session:
            holder = "nobody" if self._seat is None else self._seat.name
            raise Refused(f"only the operator may do that; {holder} has the seat")

    def may_operate(self, session: Session) -> None:
        """Raises Refused for one that may only look on."""
        if session.role is not Role.OPERATOR:
            raise Refused("this session may only look on")

    def take_seat(self, session: Session, now: float) -> bool:
        """True when it has the seat now; otherwise the holder is shown that it asks."""
        self.may_operate(session)
        holder = self._seat
        if holder is None or holder is session or (holder.connections == 0 and now - holder.seen > GONE_S):
            self._seat, session.asks_for_seat = session, False
            return True
        session.asks_for_seat = True
        return False

    def hand_over(self, session: Session, number: int | None) -> Session | None:
        """The seat goes to the session of that number, or is free; who has it now. Raises Refused."""
        self.operates(session)
        if number is None:
            self._seat = None
            return None
        heir = next((each for each in self._sessions.values() if each.number == number), None)
        if heir is None or heir.role is not Role.OPERATOR:
            raise Refused("there is no such session that may operate", 404)
        self._seat, heir.asks_for_seat = heir, False
        return heir

    def document(self, session: Session) -> dict[str, Any]:
        """What one session is shown of all."""
        return {
            "kind": "people",
            "me": {"number": session.number, "name": session.name, "role": session.role},
            "operates": self._seat is session,
            "operator": None if self._seat is None else {"number": self._seat.number, "name": self._seat.name},
            "people": [
                {"number": each.number, "name": each.name, "role": each.role, "asks": each.asks_for_seat}
                for each in self._sessions.values()
                if each.connections > 0
            ],
        }

    def _forget(self, now: float) -> None:
        for session in [each for each in self._sessions.values() if not each.connections and now - each.seen > IDLE_S]:
            self.leave(session)
