"""The emergency stop: ahead of everything else that the console does, with threads of its own."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from rover.console.desk import Desk
from rover.console.sessions import Refused, Session
from rover.errors import RoverError
from rover.mission.commands import Word
from rover.mission.ear import ask

# Kept for this alone: whatever else blocks, these are free.
THREADS = ThreadPoolExecutor(4, thread_name_prefix="emergency")


async def cut_motors(desk: Desk, session: Session, address: str, run: str) -> dict[str, Any]:
    """Says it to the mission, for whoever may operate, with or without the seat."""
    try:
        desk.sessions.may_operate(session)
        loop = asyncio.get_running_loop()
        told = await loop.run_in_executor(THREADS, ask, desk.folder(run), {"op": Word.EMERGENCY.value})
        answer: dict[str, Any] = {"ok": True, "state": told.get("state"), "says": told.get("says")}
    except (Refused, RoverError) as error:
        answer = {"ok": False, "error": str(error)}
    loop = asyncio.get_running_loop()
    await loop.run_in_executor(THREADS, desk.audit.note, session, address, "emergency", run, answer.get("error", "ok"))
    return answer
