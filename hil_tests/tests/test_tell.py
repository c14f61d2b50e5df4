"""`rover tell` speaks to a mission on its way, and a replay of what was said is the mission as it was driven."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from rover.errors import PreflightFailed
from rover.mission.ear import connect
from rover_hil.firmware_process import find_binary

pytestmark = [pytest.mark.rig("sitl"), pytest.mark.slow]

ROVER = str(Path(sys.executable).with_name("rover"))
MISSION = Path(__file__).resolve().parent / "missions" / "small.toml"
PATIENCE_S = 120.0


class Running:
    """A mission on its way."""

    def __init__(self, out: Path, *options: str) -> None:
        self.out = out
        command = [ROVER, "run", str(MISSION), "--seed", "2", "--out", str(out), "--json", "--quiet", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def tell(self, *words: str) -> dict[str, Any]:
        done = self.ask(*words)
        assert done.returncode == 0, done.stderr
        told: dict[str, Any] = json.loads(done.stdout)
        return told

    def ask(self, *words: str) -> subprocess.CompletedProcess[str]:
        line = [ROVER, "tell", str(self.out), *words, "--json"]
        return subprocess.run(line, capture_output=True, text=True, timeout=60.0, check=False)

    def wait_until(self, *states: str) -> dict[str, Any]:
        deadline = time.monotonic() + PATIENCE_S
        while (told := self.tell("state"))["state"] not in states:
            assert time.monotonic() < deadline, told
        return told

    def end(self) -> tuple[int, dict[str, Any]]:
        printed, said = self.process.communicate(timeout=PATIENCE_S)
        assert printed, said
        return self.process.returncode, json.loads(printed)


def firmware(folder: Path) -> Path:
    """A UF2 file of one block, so that `rover flash` comes as far as the port."""
    path = folder / "one-block.uf2"
    head = struct.pack("<8I", 0x0A324655, 0x9E5D5157, 0x2000, 0x10000000, 256, 0, 1, 0xE48BFF56)
    path.write_bytes(head + bytes(476) + struct.pack("<I", 0x0AB16F30))
    return path


def count_messages(run: Path, watched: Counter[str]) -> None:
    """Looks on until the mission's end."""
    with connect(run) as client, client.makefile("rb") as lines:
        client.settimeout(None)
        client.sendall(b'{"op": "watch"}\n')
        for line in lines:
            watched[json.loads(line)["kind"]] += 1


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    try:
        find_binary()
    except PreflightFailed as missing:
        pytest.skip(str(missing))
    # A path longer than a socket's address has room for.
    running = Running(tmp_path_factory.mktemp("told") / ("long-" * 20) / "run")
    deadline = time.monotonic() + PATIENCE_S
    while not (running.out / "tell.sock").exists():
        assert running.process.poll() is None, running.process.stderr
        assert time.monotonic() < deadline
        time.sleep(0.05)
    yield running
    running.process.kill()
    running.process.communicate()


def test_a_mission_is_paused_goes_on_leaves_a_goal_out_and_comes_home(mission: Running) -> None:
    watched: Counter[str] = Counter()
    threading.Thread(target=count_messages, args=(mission.out, watched), daemon=True).start()
    assert mission.tell("state")["state"] in ("start", "look")
    mission.wait_until("drive")
    mission.tell("pause")
    stands = mission.wait_until("paused")
    assert stands["says"] == "paused: paused by the operator"
    time.sleep(0.5)
    still = mission.tell("state")
    assert still["time_s"] > stands["time_s"]
    assert (still["x"], still["y"]) == pytest.approx((stands["x"], stands["y"]), abs=0.01)

    # Whoever asks for the state of the rover is answered by the mission; who would drive it is refused.
    port = json.loads((mission.out / "rig.json").read_text())["port"]
    asked = subprocess.run([ROVER, "status", "--port", port, "--json"], capture_output=True, text=True, timeout=60.0)
    assert asked.returncode == 0, asked.stderr
    told = json.loads(asked.stdout)
    assert (told["state"], told["mission"]["state"], told["board"]) == ("Armed", "paused", "Sitl")
    doctor = subprocess.run([ROVER, "doctor", "--port", port, "--json"], capture_output=True, text=True, timeout=60.0)
    assert "a mission drives it" in json.loads(doctor.stdout)["checks"][-1]["detail"]
    monitor = [ROVER, "monitor", "--port", port, "--seconds", "3", "--json"]
    moments = [json.loads(line) for line in subprocess.check_output(monitor, text=True, timeout=60.0).splitlines()]
    assert len(moments) >= 2
    assert {each["state"] for each in moments} == {"Armed"}
    assert moments[-1]["time_s"] > moments[0]["time_s"] == 0.0
    assert moments[0]["left_counts"] != 0
    assert moments[-1]["left_counts"] == pytest.approx(moments[0]["left_counts"], abs=5)
    assert moments[-1]["battery_v"] == pytest.approx(told["battery_v"], abs=0.5)
    for other in (["link", "bench", "--seconds", "1"], ["flash", "--file", str(firmware(mission.out))]):
        refused = subprocess.run([ROVER, *other, "--port", port], capture_output=True, text=True, timeout=60.0)
        assert refused.returncode == 3, refused.stderr
        assert f"the port {port} is in use by rover run" in refused.stderr
        assert f"pid {mission.process.pid}" in refused.stderr

    unknown = mission.ask("skip", "place-99")
    assert unknown.returncode == 2
    assert "no such goal" in unknown.stderr
    assert still["goals"], "the field of this seed has nothing to inspect: the test needs another"
    assert still["goals"][0] not in mission.tell("skip", still["goals"][0])["goals"]

    mission.tell("go")
    mission.wait_until("drive", "decide", "inspect")
    mission.tell("home")
    code, summary = mission.end()
    assert (code, summary["status"], summary["reason"]) == (5, "aborted", "called home by the operator")
    assert summary["home"] == {"reached": True, "reason": "at the launch"}
    assert not (mission.out / "tell.sock").exists()

    over = mission.ask("state")
    assert over.returncode == 2
    assert "no mission runs there" in over.stderr

    replayed = subprocess.run(
        [ROVER, "replay", str(mission.out / "mission.mcap"), "--json"],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert json.loads(replayed.stdout)["identical"], replayed.stdout
    # That somebody looked on has changed nothing of it.
    assert set(watched) == {"state", "track", "map", "picture"}
    assert watched["state"] > 10
