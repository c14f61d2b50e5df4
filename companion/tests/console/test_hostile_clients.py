"""What no client may get, do or cost: without a token, from another site, with too much, with names that lead away."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from companion.tests.console.served import Served, serving

ASKED = [
    ("GET", "/api/runs"),
    ("GET", "/api/missions"),
    ("GET", "/api/missions/demo"),
    ("GET", "/api/runs/a"),
    ("GET", "/api/runs/a/replay"),
    ("GET", "/api/runs/a/pictures/0"),
    ("GET", "/api/runs/a/files/report.html"),
    ("POST", "/api/runs"),
    ("POST", "/api/missions"),
    ("POST", "/api/missions/check"),
    ("POST", "/api/runs/a/tell"),
    ("POST", "/api/runs/a/judgements"),
    ("POST", "/api/seat"),
    ("POST", "/api/leave"),
    ("POST", "/api/doctor"),
    ("POST", "/api/when"),
]
MISSION = """
[mission]
name = "<script>alert(1)</script>"
[area]
width_m = 2.0
height_m = 2.0
[launch]
x_m = 0.5
y_m = 0.5
"""


@pytest.fixture(scope="module")
def ada(served: Served) -> str:
    """The cookie of one who operates."""
    cookie = served.pair()
    assert served.ask("POST", "/api/seat", {"wish": "take"}, cookie)[1]["operates"]
    return cookie


def is_well(served: Served, cookie: str) -> None:
    """The console still answers those who may ask."""
    assert served.ask("GET", "/api/runs", cookie=cookie)[0] == 200
    assert served.process.poll() is None


@pytest.mark.parametrize(("method", "path"), ASKED)
def test_without_a_token_nothing_is_told_or_done(served: Served, method: str, path: str) -> None:
    for cookie in ("", "rover_session=" + "A" * 43, "rover_session="):
        status, told, _ = served.ask(method, path, {"op": "emergency"} if method == "POST" else None, cookie)
        assert (status, told["ok"]) == (401, False)


def test_every_route_of_the_api_is_in_that_list(served: Served) -> None:
    from rover.console.routes_missions import mission_routes
    from rover.console.routes_people import people_routes
    from rover.console.routes_runs import run_routes

    routes = {
        (method, route.path.replace("{run}", "a").replace("{name}", "demo").replace("{number:int}", "0")
         .replace("{file}", "report.html"))
        for route in [*people_routes(), *mission_routes(), *run_routes()]
        for method in (route.methods or ())
        if method != "HEAD"
    }  # fmt: skip
    open_ones = {("POST", "/api/pair"), ("GET", "/api/me"), ("GET", "/api/runs/a/places/{place:int}")}
    assert routes - open_ones == set(ASKED)
    assert served.ask("GET", "/api/runs/a/places/1?x=0&y=0")[0] == 401
    assert served.ask("GET", "/api/me")[1] == {"ok": True, "me": None}


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "", "https://127.0.0.1", "http://127.0.0.1:1"])
def test_another_site_may_not_use_the_browser_of_the_operator(served: Served, ada: str, origin: str) -> None:
    assert served.ask("POST", "/api/seat", {"wish": "give", "to": None}, ada, origin=origin)[0] == 403
    assert served.ask("GET", "/api/me", cookie=ada)[1]["operates"]


def test_a_page_of_another_site_may_not_even_read(served: Served, ada: str) -> None:
    assert served.ask("GET", "/api/runs", cookie=ada, sec_fetch_site="cross-site", sec_fetch_mode="no-cors")[0] == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "", "[", "a b"])
def test_a_name_that_somebody_points_here_is_not_ours(served: Served, ada: str, host: str) -> None:
    with socket.create_connection(served.address, timeout=10.0) as client:
        head = f"GET /api/runs HTTP/1.1\r\nhost: {host}\r\ncookie: {ada}\r\nconnection: close\r\n\r\n"
        client.sendall(head.encode())
        assert client.makefile("rb").readline().split()[1] in (b"400", b"421")


def test_the_cookie_is_kept_from_scripts_and_other_sites(served: Served) -> None:
    _, _, answer = served.ask("POST", "/api/pair", {"code": served.codes["viewer_code"], "name": ""})
    cookie = answer.getheader("set-cookie", "").lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie


def test_the_page_may_run_no_script_but_its_own(served: Served) -> None:
    status, _, answer = served.ask("GET", "/")
    policy = answer.getheader("content-security-policy", "")
    assert status == 200
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy


def test_who_may_look_on_may_do_nothing(served: Served) -> None:
    viewer = served.pair("viewer_code", "Eve")
    assert served.ask("GET", "/api/runs", cookie=viewer)[0] == 200
    for path, content in [
        ("/api/seat", {"wish": "take"}),
        ("/api/runs", {"mission": "demo"}),
        ("/api/missions", {"name": "a", "text": MISSION}),
        ("/api/runs/a/judgements", {"verdict": "marked", "x": 0, "y": 0}),
    ]:
        assert served.ask("POST", path, content, viewer)[0] == 403
    told = served.ask("POST", "/api/runs/a/tell", {"op": "emergency"}, viewer)[1]
    assert told == {"ok": False, "error": "this session may only look on"}


def test_who_has_no_seat_may_not_command(served: Served, ada: str) -> None:
    other = served.pair(name="Bob")
    status, told, _ = served.ask("POST", "/api/runs", {"mission": "demo"}, other)
    assert (status, told["error"]) == (403, "only the operator may do that; Ada has the seat")
    assert not served.ask("POST", "/api/seat", {"wish": "take"}, other)[1]["operates"]


@pytest.mark.parametrize(
    "name",
    ["..", "../x", "..%2f..%2fetc", "%2e%2e", ".console", "a/b", "a%00", "a%0ab", "%ff", "x" * 5000, "~", "nul\\x"],
)
def test_names_lead_nowhere_but_to_runs(served: Served, ada: str, name: str) -> None:
    for path in (f"/api/runs/{name}", f"/api/runs/{name}/replay", f"/api/missions/{name}", f"/{name}"):
        assert served.ask("GET", path, cookie=ada)[0] in (400, 404)
    is_well(served, ada)


def test_files_of_a_run_are_those_that_a_run_leaves_and_no_others(served: Served, ada: str) -> None:
    run, secret = served.runs / "one", served.runs.parent / "secret"
    run.mkdir()
    secret.write_text("secret")
    (run / "summary.json").write_text('{"status": "done"}')
    (run / "other.txt").write_text("not of the run")
    (run / "map.png").symlink_to(secret)
    (served.runs / "leads-away").symlink_to(served.runs.parent)
    assert served.ask("GET", "/api/runs/one/files/summary.json", cookie=ada)[0] == 200
    for path in ("one/files/other.txt", "one/files/map.png", "one/files/..%2f..%2fsecret", "one/files/tell.sock",
                 "one/files/", "leads-away/files/secret"):  # fmt: skip
        assert served.ask("GET", f"/api/runs/{path}", cookie=ada)[0] == 404, path


@pytest.mark.parametrize(("section", "key"), [("rover", "vehicle"), ("rover", "camera"), ("detector", "model")])
def test_a_mission_may_not_name_files_elsewhere(served: Served, ada: str, section: str, key: str) -> None:
    for value in ("/etc/passwd", "../../etc/passwd", "a/b.toml"):
        text = MISSION + f'[{section}]\n{key} = "{value}"\n'
        status, told, _ = served.ask("POST", "/api/missions", {"name": "a", "text": text}, ada)
        assert status == 400
        assert "must lie beside the mission file" in told["error"]
        assert "root:" not in told["error"]


def test_a_script_in_a_name_stays_text(served: Served, ada: str) -> None:
    status, told, answer = served.ask("POST", "/api/missions/check", {"name": "a", "text": MISSION}, ada)
    assert (status, told["problem"]) == (200, "")
    assert told["mission"]["name"] == "<script>alert(1)</script>"
    assert answer.getheader("content-type") == "application/json"
    assert answer.getheader("x-content-type-options") == "nosniff"


@pytest.mark.parametrize(
    "text", ["x = " + "[" * 5000, "a.b = 1\n[a.b]", "x = inf\n", "d = 2026-01-01\n", "\0", 5, None]
)
def test_what_is_no_mission_is_refused_in_one_line(served: Served, ada: str, text: object) -> None:
    status, told, _ = served.ask("POST", "/api/missions/check", {"name": "a", "text": text}, ada)
    assert status in (200, 400)
    assert told.get("problem") or told.get("error")
    is_well(served, ada)


@pytest.mark.parametrize("raw", [b"", b"[]", b"{", b"\xff\xfe", b"[" * 100_000, b'"x"', b"null"])
def test_what_is_no_request_is_refused(served: Served, ada: str, raw: bytes) -> None:
    assert served.ask("POST", "/api/seat", cookie=ada, raw=raw)[0] == 400
    is_well(served, ada)


def test_a_hundred_megabytes_are_not_even_read(served: Served, ada: str) -> None:
    with socket.create_connection(served.address, timeout=10.0) as client:
        head = (
            f"POST /api/missions HTTP/1.1\r\nhost: {served.host}\r\norigin: http://{served.host}\r\ncookie: {ada}\r\n"
        )
        client.sendall(f"{head}content-length: {100 * 2**20}\r\n\r\n".encode())
        assert client.makefile("rb").readline().split()[1] == b"413"
    with socket.create_connection(served.address, timeout=10.0) as client:
        client.sendall(f"{head}transfer-encoding: chunked\r\n\r\n".encode())
        chunk = b"10000\r\n" + b"x" * 65536 + b"\r\n"
        sent = 0
        try:
            while sent < 100 * 2**20:
                client.sendall(chunk)
                sent += len(chunk)
        except OSError:
            pass
        assert sent < 20 * 2**20
    is_well(served, ada)


def test_a_hundred_megabytes_over_the_live_connection_end_it(served: Served, ada: str) -> None:
    async def send() -> int | None:
        async with connect(f"ws://{served.host}/api/live", additional_headers={"cookie": ada},
                           origin=f"http://{served.host}", max_size=None) as live:  # type: ignore[arg-type] # fmt: skip
            try:
                await live.send("x" * (100 * 2**20))
                while True:
                    await asyncio.wait_for(live.recv(), 20.0)
            except ConnectionClosed as closed:
                return closed.rcvd.code if closed.rcvd else None

    assert asyncio.run(send()) in (1009, None)
    is_well(served, ada)


@pytest.mark.parametrize("headers", [{}, {"cookie": "rover_session=wrong"}])
def test_the_live_connection_needs_a_token(served: Served, headers: dict[str, str]) -> None:
    async def look() -> str:
        try:
            async with connect(f"ws://{served.host}/api/live?run=one", additional_headers=headers,
                               origin=f"http://{served.host}") as live:  # type: ignore[arg-type] # fmt: skip
                return str(await live.recv())
        except (InvalidStatus, ConnectionClosed) as refused:
            return type(refused).__name__

    assert asyncio.run(look()) in ("InvalidStatus", "ConnectionClosedError", "ConnectionClosedOK")


def test_the_live_connection_is_not_for_other_sites(served: Served, ada: str) -> None:
    async def look(origin: str | None) -> str:
        try:
            async with connect(f"ws://{served.host}/api/live", additional_headers={"cookie": ada},
                               origin=origin) as live:  # type: ignore[arg-type] # fmt: skip
                return str(await live.recv())
        except (InvalidStatus, ConnectionClosed) as refused:
            return type(refused).__name__

    assert asyncio.run(look("http://evil.example")) == "InvalidStatus"
    assert asyncio.run(look(None)) == "InvalidStatus"
    assert '"kind": "people"' in asyncio.run(look(f"http://{served.host}"))


def test_a_flood_over_the_live_connection_ends_it(served: Served, ada: str) -> None:
    async def flood() -> bool:
        async with connect(f"ws://{served.host}/api/live", additional_headers={"cookie": ada},
                           origin=f"http://{served.host}") as live:  # type: ignore[arg-type] # fmt: skip
            try:
                for _ in range(5000):
                    await live.send('{"op": "nothing"}')
                while True:
                    await asyncio.wait_for(live.recv(), 10.0)
            except ConnectionClosed:
                return True

    assert asyncio.run(flood())
    is_well(served, ada)


def test_what_was_done_and_refused_is_in_the_audit_log(served: Served, ada: str) -> None:
    served.ask("POST", "/api/runs/one/judgements", {"verdict": "marked", "x": 1, "y": 1, "note": "a\nb"}, ada)
    said = [(line["who"], line["what"], line["about"]) for line in served.audit()]
    assert ("Ada", "pair", "") in said
    assert ("Ada", "take the seat", "") in said
    assert ("Ada", "judge marked", "one") in said
    assert ("Eve", "emergency", "a") in said
    assert (served.runs / ".console" / "audit.jsonl").stat().st_mode & 0o077 == 0


def test_who_guesses_codes_is_stopped_and_who_floods_is_slowed_down(tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        ada = served.pair()
        statuses = [served.ask("POST", "/api/pair", {"code": f"AAAAAAA{n}"})[0] for n in range(8)]
        assert statuses[:4] == [403] * 4
        assert statuses[-1] == 429
        assert served.ask("POST", "/api/pair", {"code": served.codes["pairing_code"]})[0] == 429

        begun = time.monotonic()
        flood = [served.ask("GET", "/api/me")[0] for _ in range(400)]
        assert 429 in flood or time.monotonic() - begun > 5.0
        # Who has a session is not slowed down by those who have none.
        assert served.ask("GET", "/api/runs", cookie=ada)[0] == 200
        assert json.dumps(served.audit()).count("too many tries") >= 1
