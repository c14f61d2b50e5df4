"""A console as its user starts it, and a client that says exactly what it is told to."""

from __future__ import annotations

import http.client
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

ROVER = str(Path(sys.executable).with_name("rover"))


@dataclass
class Served:
    """A running console; `codes` is the first line that it printed."""

    runs: Path
    codes: dict[str, str]
    process: subprocess.Popen[str]

    @property
    def url(self) -> str:
        return self.codes["url"]

    @property
    def address(self) -> tuple[str, int]:
        host, _, port = self.host.partition(":")
        return host, int(port)

    @property
    def host(self) -> str:
        return urlsplit(self.url).netloc

    def ask(
        self, method: str, path: str, content: Any = None, cookie: str = "", raw: bytes | None = None, **headers: str
    ) -> tuple[int, dict[str, Any], http.client.HTTPResponse]:
        """Status, JSON (or nothing), and the answer itself. `headers` with _ for -; an empty one is left out."""
        connection = http.client.HTTPConnection(self.host, timeout=20.0)
        given = {"origin": f"http://{self.host}", "cookie": cookie}
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        data = raw if raw is not None else None if content is None else json.dumps(content).encode()
        connection.request(method, path, data, {name: value for name, value in given.items() if value})
        answer = connection.getresponse()
        read = answer.read()
        connection.close()
        try:
            told = json.loads(read)
        except ValueError:
            told = {}
        return answer.status, told, answer

    def pair(self, code: str = "pairing_code", name: str = "Ada") -> str:
        """The cookie of a new session."""
        status, told, answer = self.ask("POST", "/api/pair", {"code": self.codes[code], "name": name})
        assert status == 200, told
        cookie = answer.getheader("set-cookie")
        assert cookie is not None
        return cookie.split(";")[0]

    def audit(self) -> list[dict[str, Any]]:
        lines = (self.runs / ".console" / "audit.jsonl").read_text().splitlines()
        return [json.loads(line) for line in lines]


@contextmanager
def serving(runs: Path) -> Iterator[Served]:
    """On a free port, until the block ends."""
    line = [ROVER, "console", "--listen", "127.0.0.1:0", "--runs", str(runs)]
    process = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    first = process.stdout.readline()
    try:
        assert first, process.stderr.read() if process.stderr else ""
        yield Served(runs, json.loads(first), process)
    finally:
        process.terminate()
        process.communicate(timeout=20.0)
