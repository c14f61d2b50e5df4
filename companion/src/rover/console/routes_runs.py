"""What may be asked of runs: those that are on their way, and those that are over."""

from __future__ import annotations

from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route

from rover.console.answer import answered
from rover.console.desk import Desk, body
from rover.console.emergency import cut_motors
from rover.console.guard import REPORT_POLICY, address_of
from rover.console.judgement import judge, read_judgements
from rover.console.runs import is_running, list_runs, media_type, read_summary, run_document, run_file
from rover.console.sessions import Refused
from rover.console.start import wish_of
from rover.errors import RoverError
from rover.mission.commands import Word
from rover.mission.ear import ask

WORDS = ("state", *(word.value for word in Word if word is not Word.EMERGENCY))


async def runs(desk: Desk, request: Request) -> dict[str, Any]:
    """The list, and what is beginning."""
    desk.session(request)
    return {"runs": await run_in_threadpool(list_runs, desk.runs), "beginning": desk.started.beginning()}


async def start(desk: Desk, request: Request) -> dict[str, Any]:
    """Begins a mission."""
    session = desk.session(request)
    desk.sessions.operates(session)
    content = await body(request)
    mission = desk.missions.path(str(content.get("mission", "")))
    resume = content.get("resume")
    wish = wish_of(content, desk.folder(str(resume)) if resume else None)
    told = await run_in_threadpool(desk.missions.read, mission.stem)
    if told["problem"]:
        raise Refused(told["problem"], 400)
    name = await run_in_threadpool(desk.started.start, mission, told["mission"]["name"], wish)
    desk.note(request, session, "start", f"{mission.stem} {' '.join(wish.options())}", name)
    return {"run": name}


async def run(desk: Desk, request: Request) -> dict[str, Any]:
    """One run: its summary, its judgements, and how its process stands."""
    desk.session(request)
    name = request.path_params["run"]
    folder = desk.folder(name)

    def read() -> dict[str, Any]:
        return {
            "run": run_document(folder) if folder.is_dir() else None,
            "summary": read_summary(folder),
            "judgements": read_judgements(folder),
            "process": desk.started.document(name),
            "running": is_running(folder),
        }

    return await run_in_threadpool(read)


async def tell(desk: Desk, request: Request) -> dict[str, Any]:
    """What `rover tell` says, by the operator."""
    session, name = desk.session(request), request.path_params["run"]
    content = await body(request)
    word, goal = content.get("op"), content.get("id", "")
    if word == Word.EMERGENCY:
        return await cut_motors(desk, session, address_of(request.scope), name)
    desk.sessions.operates(session)
    if word not in WORDS or not isinstance(goal, str) or len(goal) > 100:
        raise Refused(f"a word is one of {', '.join(WORDS)}", 400)
    try:
        told = await run_in_threadpool(ask, desk.folder(name), {"op": word, "id": goal})
    except RoverError as error:
        desk.note(request, session, f"{word} {goal}".strip(), name, str(error))
        raise
    desk.note(request, session, f"{word} {goal}".strip(), name)
    return told


async def add_judgement(desk: Desk, request: Request) -> dict[str, Any]:
    """Confirm, reject, or mark by hand."""
    session, name = desk.session(request), request.path_params["run"]
    desk.sessions.may_operate(session)
    folder, content = desk.folder(name), await body(request)
    known = {int(found["id"]) for found in read_summary(folder).get("detections", [])} | desk.places(name)
    entry = await run_in_threadpool(judge, folder, session, content, known)
    desk.note(request, session, f"judge {entry['verdict']} {entry.get('place', '')}".strip(), name)
    return {"judgement": entry}


async def replay(desk: Desk, request: Request) -> dict[str, Any]:
    """The log for the time slider."""
    desk.session(request)
    known = await run_in_threadpool(desk.replays.of, desk.folder(request.path_params["run"]))
    return await run_in_threadpool(known.document)


async def views(desk: Desk, request: Request) -> dict[str, Any]:
    """Pictures that show a place."""
    desk.session(request)
    try:
        x, y = float(request.query_params["x"]), float(request.query_params["y"])
    except (KeyError, ValueError):
        raise Refused("x and y are expected", 400) from None
    known = await run_in_threadpool(desk.replays.of, desk.folder(request.path_params["run"]))
    return {"views": await run_in_threadpool(known.views, request.path_params["place"], x, y)}


async def picture(desk: Desk, request: Request) -> Response:
    """One thermal picture of the log."""
    desk.session(request)
    known = await run_in_threadpool(desk.replays.of, desk.folder(request.path_params["run"]))
    number = request.path_params["number"]
    if number >= len(known.pictures):
        raise Refused("there is no such picture", 404)
    return Response(known.pictures[number][1], media_type="image/png")


async def file(desk: Desk, request: Request) -> Response:
    """A file of a run."""
    desk.session(request)
    name = request.path_params["file"]
    path = run_file(desk.runs, request.path_params["run"], name)
    shown = name.endswith((".html", ".png"))
    headers = {"content-security-policy": REPORT_POLICY} if name.endswith(".html") else {}
    saved = None if shown and "save" not in request.query_params else f"{request.path_params['run']}-{name}"
    return FileResponse(path, media_type=media_type(name), filename=saved, headers=headers)


def run_routes() -> list[Route]:
    """All of them."""
    return [
        Route("/api/runs", answered(runs)),
        Route("/api/runs", answered(start), methods=["POST"]),
        Route("/api/runs/{run}", answered(run)),
        Route("/api/runs/{run}/tell", answered(tell), methods=["POST"]),
        Route("/api/runs/{run}/judgements", answered(add_judgement), methods=["POST"]),
        Route("/api/runs/{run}/replay", answered(replay)),
        Route("/api/runs/{run}/places/{place:int}", answered(views)),
        Route("/api/runs/{run}/pictures/{number:int}", answered(picture)),
        Route("/api/runs/{run}/files/{file}", answered(file)),
    ]
