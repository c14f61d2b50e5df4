"""A world file: what it may say, what ships, and that all of it switched off is the world as it is without one."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rover.errors import BadInput
from rover.mission.config import Mission, load
from rover.vision.camera.file import load_camera
from rover_hil.ground import build
from rover_hil.plant_config import build_plant, plant_config
from rover_hil.world.catalogue import EFFECTS
from rover_hil.world.example import example
from rover_hil.world.file import SHIPPED, find_world, load_world
from rover_plant import Plant

LOOK = Path(__file__).resolve().parent / "missions" / "look.toml"
ROVER = str(Path(sys.executable).with_name("rover"))


def in_world(tmp_path: Path, text: str) -> Mission:
    """The mission that looks around, in a world of that text."""
    file = tmp_path / "world.toml"
    file.write_text(text)
    mission = load(LOOK)
    return replace(mission, field=replace(mission.field, world=str(file)))


def plant_of(mission: Mission, seed: int = 3) -> Plant:
    return build_plant(mission, build(mission, seed), load_camera(mission.rover.camera), seed)


def test_the_example_that_is_printed_names_every_effect_with_its_source_and_can_be_read(tmp_path: Path) -> None:
    printed = subprocess.run([ROVER, "hil", "world", "--example"], capture_output=True, text=True, check=True).stdout
    (tmp_path / "world.toml").write_text(printed)
    world = load_world(tmp_path / "world.toml")
    assert set(world.effects) == set(EFFECTS)
    assert printed.count("# Source: ") == len(EFFECTS)


@pytest.mark.parametrize("name", ["mild", "hard", "brutal"])
def test_a_world_that_ships_can_be_named_in_a_mission(name: str, tmp_path: Path) -> None:
    mission = tmp_path / "mission.toml"
    mission.write_text(LOOK.read_text() + f'world = "{name}"\n')
    assert load(mission).field.world == name
    assert load_world(find_world(name)).effects
    assert len(list(SHIPPED.glob("*.toml"))) == 3


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[camera.mont]\non = true\n", "did you mean mount"),
        ("[camera.mount]\npitch_rad = 1\n", "pitch_deg"),
        ("[camera.mount]\npitch_deg = 90\n", "outside"),
        ("[camera.mount]\non = 1\n", "true or false"),
        ("[camra.mount]\n", "did you mean camera"),
        ("camera = 3\n", "must be a table"),
    ],
)
def test_a_mistake_is_one_line_that_names_its_key(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=told):
        plant_of(in_world(tmp_path, text))


def test_a_world_that_is_not_there_is_said_with_those_that_are(tmp_path: Path) -> None:
    mission = load(LOOK)
    with pytest.raises(BadInput, match="brutal, hard, mild"):
        build(replace(mission, field=replace(mission.field, world="mildd")), 1)
    lost = tmp_path / "mission.toml"
    lost.write_text(LOOK.read_text() + 'world = "nowhere.toml"\n')
    with pytest.raises(BadInput, match="no such file"):
        load(lost)


def test_with_everything_off_ground_and_plant_are_the_same_to_the_byte(tmp_path: Path) -> None:
    friendly, off = load(LOOK), in_world(tmp_path, example(on=False))
    one, other = build(friendly, 3), build(off, 3)
    assert one.temperature.tobytes() == other.temperature.tobytes()
    assert one.height.tobytes() == other.height.tobytes()
    assert json.dumps(one.truth()) == json.dumps(other.truth())
    assert other.layers == ()
    camera = load_camera(friendly.rover.camera)
    assert plant_config(friendly, one, camera, 3) == plant_config(off, other, camera, 3)


@pytest.mark.rig("sitl")
def test_with_everything_off_a_mission_leaves_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "off.toml").write_text(example(on=False))
    (tmp_path / "friendly.toml").write_text(LOOK.read_text())
    (tmp_path / "unfriendly.toml").write_text(LOOK.read_text() + 'world = "off.toml"\n')
    left = []
    for name in ("friendly", "unfriendly"):
        out = tmp_path / name
        subprocess.run([ROVER, "run", f"{out}.toml", "--seed", "4", "--out", str(out), "--quiet"], check=False)
        summary = json.loads((out / "summary.json").read_text())
        told = {key: value for key, value in summary.items() if key not in ("wall_clock", "out", "versions")}
        files = [(out / file).read_bytes() for file in ("truth.tum", "trajectory.tum", "truth.json", "map.png")]
        left.append((json.dumps(told), *files))
    assert left[0] == left[1]


@pytest.mark.parametrize("effect", [name for name in EFFECTS if not name.startswith("weather.dew")])
def test_every_effect_changes_what_the_rover_gets(effect: str, tmp_path: Path) -> None:
    brutal = load_world(find_world("brutal"))
    friendly, unfriendly = plant_of(load(LOOK)), plant_of(in_world(tmp_path, brutal.alone(effect).text()))
    assert traces(friendly) != traces(unfriendly)


def traces(plant: Plant) -> bytes:
    """All that comes out of a plant in ten seconds of driving and turning."""
    out = bytearray()
    for step in range(10_000):
        plant.step(0.3, 0.3 if step < 1000 else -0.3, True)
        if step % 60 == 0:
            plant.trigger_sonar((step // 60) % 3)
        echo = plant.poll_echo()
        if echo is not None:
            out += f"{plant.now_us} {echo}".encode()
        if step % 20 == 0:
            out += np.array([*plant.pose(), *plant.encoders(), *plant.battery()]).tobytes()
            for sequence, exposed, delivered, ffc, pixels in plant.take_frames():
                out += f"{sequence} {exposed} {delivered} {ffc}".encode() + pixels
    return bytes(out)
