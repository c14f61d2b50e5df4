"""What may be asked of mission files, and of the hours and the means to drive them."""

from __future__ import annotations

import asyncio
import json
import sys
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.routing import Route

from rover.console.answer import answered
from rover.console.desk import Desk, body
from rover.console.missions import rendered
from rover.console.sessions import Refused

CHECK_WITHIN_S = 60.0
# One at a time: a check takes seconds of a whole core.
CHECKING = asyncio.Semaphore(1)


async def missions(desk: Desk, request: Request) -> dict[str, Any]:
    """Their names."""
    desk.session(request)
    return await run_in_threadpool(desk.missions.names)


async def mission(desk: Desk, request: Request) -> dict[str, Any]:
    """One of them."""
    desk.session(request)
    return await run_in_threadpool(desk.missions.read, request.path_params["name"])


async def check(desk: Desk, request: Request) -> dict[str, Any]:
    """What the reader of `rover run` says of a text, or of a document of which it makes one."""
    desk.sessions.may_operate(desk.session(request))
    text, name = _text(await body(request))
    return await run_in_threadpool(desk.missions.check, text, name)


async def save(desk: Desk, request: Request) -> dict[str, Any]:
    """Keeps one."""
    session = desk.session(request)
    desk.sessions.may_operate(session)
    text, name = _text(await body(request))
    told = await run_in_threadpool(desk.missions.save, text, name)
    desk.note(request, session, "save", name)
    return told


async def doctor(desk: Desk, request: Request) -> dict[str, Any]:
    """What `rover doctor` finds on this computer."""
    desk.sessions.may_operate(desk.session(request))
    return await _command("doctor", "--json")


async def when(desk: Desk, request: Request) -> dict[str, Any]:
    """What `rover when` says of a site."""
    desk.sessions.may_operate(desk.session(request))
    text = rendered({"site": (await body(request)).get("site", {})})
    file = desk.audit.path.with_name("site.toml")
    async with CHECKING:
        await run_in_threadpool(file.write_text, text, "utf-8")
        return await _command("when", str(file), "--json", held=True)


async def _command(*words: str, held: bool = False) -> dict[str, Any]:
    """The JSON of a command of `rover`, as a process that may not last. Raises Refused with what it said."""
    if not held:
        async with CHECKING:
            return await _command(*words, held=True)
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "rover.cli.main", *words),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        printed, said = await asyncio.wait_for(process.communicate(), CHECK_WITHIN_S)
        told = json.loads(printed)
    except asyncio.TimeoutError:
        process.kill()
        raise Refused(f"rover {words[0]} took longer than {CHECK_WITHIN_S:g} s", 504) from None
    except ValueError:
        line = said.decode("utf-8", "replace").strip().splitlines()[-1:] or ["it said nothing"]
        raise Refused(line[0].removeprefix("rover: "), 400) from None
    return told if isinstance(told, dict) else {"told": told}


def _text(content: dict[str, Any]) -> tuple[str, str]:
    """The text of a mission, and its name."""
    name = content.get("name", "mission")
    text = content.get("text")
    if text is None and isinstance(content.get("document"), dict):
        text = rendered(content["document"])
    if not isinstance(text, str) or not isinstance(name, str):
        raise Refused("a mission's name and text are expected", 400)
    return text, name


def mission_routes() -> list[Route]:
    """All of them."""
    return [
        Route("/api/missions", answered(missions)),
        Route("/api/missions", answered(save), methods=["POST"]),
        Route("/api/missions/check", answered(check), methods=["POST"]),
        Route("/api/missions/{name}", answered(mission)),
        Route("/api/doctor", answered(doctor), methods=["POST"]),
        Route("/api/when", answered(when), methods=["POST"]),
    ]
