"""Maps of map_server as the world writes them: each is read as it is meant, or refused for the true reason."""

from __future__ import annotations

import io
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from rover.errors import BadInput
from rover.mapping.map_picture import read_shades
from rover.mapping.map_server import StoredMap, read

WALL, GREY, GROUND = 0, 205, 254
PLAIN = {"image": "map.pgm", "resolution": 0.05, "origin": [0.0, 0.0, 0.0]}


def pgm(values: list[int], maximum: int = 255, width: int | None = None) -> bytes:
    kind = ">u2" if maximum > 255 else "u1"
    return f"P5\n{width or len(values)} 1\n{maximum}\n".encode() + np.array(values, kind).tobytes()


def encoded(picture: Image.Image, kind: str, **options: Any) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, kind, **options)
    return buffer.getvalue()


def a_map(folder: Path, text: str | bytes, picture: bytes = pgm([WALL, GREY, GROUND]), name: str = "map.pgm") -> Path:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(picture)
    (folder / "map.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder / "map.yaml"


def with_keys(**keys: Any) -> str:
    return str(yaml.safe_dump(PLAIN | keys))


def cells(stored: StoredMap) -> str:
    """The lowest row: `#` occupied, `.` free, `?` unknown."""
    return "".join("#" if o else "." if s else "?" for s, o in zip(stored.seen[0], stored.occupied[0], strict=True))


def complaint(path: Path) -> str:
    """What is said against a map; nothing when it is read. Any other error fails the test."""
    try:
        read(path)
    except BadInput as error:
        return str(error)
    return ""


def refusal(path: Path) -> str:
    message = complaint(path)
    assert message, "the map was read"
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    "text",
    [
        "image: map.pgm\nresolution: 0.05\norigin:\n- 0.0\n- 0.0\n- 0.0\n",
        "image: map.pgm\nresolution: 0.05\norigin:\n  - 0\n  - 0\n  - 0\n",
        "image: map.pgm\nresolution: 0.05\norigin: [0.0,\n   0.0,\n   0.0]\n",
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0,]\n",
        "\ufeffimage: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n",
        "image: map.pgm\r\nresolution: 0.05\r\norigin: [0, 0, 0]\r\n",
        "{image: map.pgm, resolution: 0.05, origin: [0, 0, 0]}",
        '---\n"image": "map.pgm"  # "#"\nresolution: 5.0e-2\norigin: [0, 0, 0]\n...\n',
        "image: >-\n  map.pgm\nresolution: '0.05'\norigin: &o [0, 0, 0]\nother: *o\n",
        "image: map.pgm\nresolution: 5e-2\norigin: [0, 0, 1e-9]\nmode: Trinary\nnegate: False\n",
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, -1e-6]\nnegate: no\nmode: TRINARY\n",
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 6.283185307]\n",
    ],
)
def test_yaml_is_read_in_every_style(tmp_path: Path, text: str) -> None:
    stored = read(a_map(tmp_path, text))
    assert cells(stored) == "#?."
    assert stored.resolution == 0.05
    assert stored.origin == (0.0, 0.0)


@pytest.mark.parametrize("name", ["m #1.pgm", "sub folder/a map.pgm", "it's.pgm", "Karte äöü.pgm", "no"])
def test_the_picture_may_have_any_name(tmp_path: Path, name: str) -> None:
    assert cells(read(a_map(tmp_path, with_keys(image=name), name=name))) == "#?."


@pytest.mark.parametrize(("negate", "expected"), [("true", ".##"), ("1", ".##"), ("yes", ".##"), ("false", "#?.")])
def test_negate_turns_shades_around(tmp_path: Path, negate: str, expected: str) -> None:
    assert cells(read(a_map(tmp_path, with_keys() + f"negate: {negate}\n"))) == expected


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        ("origin: [0, 0, -nan]", "origin: finite numbers are expected, got -nan"),
        ("origin: [0, 0, .nan]", "origin: finite numbers are expected, got nan"),
        ("origin: [0, 0, nan]", "origin: finite numbers are expected, got nan"),
        ("origin: [-nan, 0, 0]", "origin: finite numbers"),
        ("origin: [0, .inf, 0]", "origin: finite numbers"),
        ("origin: [0, true, 0]", "origin: finite numbers are expected, got True"),
        ("origin: [0, 0]", r"origin: [x, y, yaw] is expected"),
        ("origin: 0 0 0", r"origin: [x, y, yaw] is expected, got 0 0 0"),
        ("origin: [1, 2, 0.5]", "the map is turned by 0.5 rad"),
        ("origin: [1, 2, -1.5708]", "the map is turned by -1.5708 rad"),
        ("origin: [1, 2, 0.01]", "the map is turned by 0.01 rad"),
        ("resolution: fine", "resolution: finite numbers are expected, got fine"),
        ("resolution: 0", "resolution: a finite length above 0"),
        ("mode: dreamy", "mode: trinary, scale or raw is expected, got dreamy"),
        ("negate: maybe", "negate: 0, 1, true or false is expected, got maybe"),
        ("image: 7", "image: the name of a picture is expected, got 7"),
        ("image: none.pgm", "none.pgm: No such file"),
        ("image: .", "directory"),
        ("free_thresh: 1.5", "free_thresh: must lie between 0 and 1"),
        ("free_thresh: 0.7", "free_thresh: 0.7 lies above occupied_thresh, 0.65"),
        ("free_thresh: 0.0\noccupied_thresh: 1.0\nmode: scale", "a mask of speeds or costs is no map to plan on"),
        ("origin: [0, 0", "line 4: not valid YAML"),
        ("a: {b", "not valid YAML"),
        ("%", "not valid YAML"),
        ("\x00", "not valid YAML"),
    ],
)
def test_what_cannot_be_read_is_refused_for_the_true_reason(tmp_path: Path, keys: str, reason: str) -> None:
    key = keys.partition(":")[0]
    lines = [line for line in with_keys().splitlines() if not line.startswith((f"{key}:", "- "))]
    if key != "origin":
        lines = [line for line in lines if not line.startswith("origin")] + ["origin: [0, 0, 0]"]
    path = a_map(tmp_path, "\n".join([*lines, keys]) + "\n")
    assert reason in refusal(path)


@pytest.mark.parametrize("text", ["", "- a\n- b\n", "map\n", "7\n"])
def test_yaml_without_keys_is_no_map(tmp_path: Path, text: str) -> None:
    assert "are expected" in refusal(a_map(tmp_path, text))


@settings(max_examples=150)
@given(st.lists(st.tuples(st.integers(0, 200), st.integers(0, 255)), min_size=1, max_size=4))
def test_any_damage_to_the_yaml_gives_a_map_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, damage: list[tuple[int, int]]
) -> None:
    text = bytearray(with_keys(mode="scale", free_thresh=0.196, negate=0).encode())
    for place, value in damage:
        text[place % len(text)] = value
    path = a_map(tmp_path_factory.mktemp("damage"), bytes(text))
    assert "\n" not in complaint(path)


@pytest.mark.parametrize("maximum", [1, 15, 100, 127, 254, 255, 256, 1000, 65535])
def test_a_pgm_s_own_maximum_is_white(tmp_path: Path, maximum: int) -> None:
    stored = read(a_map(tmp_path, with_keys(), pgm([0, maximum, maximum // 2], maximum)))
    assert cells(stored)[:2] == "#."
    assert cells(stored)[2] != "."


@pytest.mark.parametrize(("values", "maximum"), [([0, 101], 100), ([0, 255], 254), ([1001, 1], 1000)])
def test_values_above_the_maximum_are_no_picture(tmp_path: Path, values: list[int], maximum: int) -> None:
    assert f"above the maximum {maximum}" in refusal(a_map(tmp_path, with_keys(), pgm(values, maximum)))


def test_a_plain_pgm_is_read_like_a_raw_one(tmp_path: Path) -> None:
    assert cells(read(a_map(tmp_path, with_keys(), b"P2\n# by hand\n3 1\n100\n0 80 100\n"))) == "#?."


TRANSPARENT = {
    "white, fully": Image.new("RGBA", (1, 1), (255, 255, 255, 0)),
    "white, half": Image.new("RGBA", (1, 1), (255, 255, 255, 128)),
    "black, fully": Image.new("RGBA", (1, 1), (0, 0, 0, 0)),
    "grey picture": Image.new("LA", (1, 1), (255, 0)),
}


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("picture", TRANSPARENT.values(), ids=TRANSPARENT.keys())
def test_nothing_is_known_where_a_picture_is_transparent(tmp_path: Path, picture: Image.Image, mode: str) -> None:
    path = a_map(tmp_path, with_keys(image="map.png", mode=mode), encoded(picture, "PNG"), "map.png")
    assert cells(read(path)) == "?"


def test_nothing_is_known_where_a_palette_is_transparent(tmp_path: Path) -> None:
    picture = Image.new("P", (3, 1))
    picture.putpalette([0, 0, 0, 255, 255, 255, 255, 255, 255])
    picture.putdata([0, 1, 2])
    path = a_map(tmp_path, with_keys(image="map.png"), encoded(picture, "PNG", transparency=2), "map.png")
    assert cells(read(path)) == "#.?"


def test_colours_count_by_their_mean(tmp_path: Path) -> None:
    picture = Image.new("RGB", (3, 1))
    picture.putdata([(255, 255, 255), (90, 90, 87), (255, 200, 160)])
    path = a_map(tmp_path, with_keys(image="map.png"), encoded(picture, "PNG"), "map.png")
    assert cells(read(path)) == ".#?"


NOISE = Image.fromarray(np.random.default_rng(3).integers(0, 256, (60, 80), np.uint8))


@pytest.mark.parametrize(("kind", "ending"), [("JPEG", "jpg"), ("PNG", "png"), ("BMP", "bmp"), ("PPM", "pgm")])
@pytest.mark.parametrize("kept", [0.3, 0.6, 0.95])
def test_a_picture_that_ends_early_is_cut(
    tmp_path: Path, kind: str, ending: str, kept: float, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = encoded(NOISE, kind)
    path = a_map(tmp_path, with_keys(image=f"map.{ending}"), whole[: int(kept * len(whole))], f"map.{ending}")
    assert refusal(path).endswith(f"map.{ending}: the picture is cut")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "picture",
    [b"", b"P5", b"{}", b"P5\n-4 1\n255\n", b"P9\n4 1\n255\n\0", b"P5\n9 1\n0\n123456789", b"P5\n99999 99999\n255\n\0"],
)
def test_what_is_no_picture_is_refused_in_one_line(tmp_path: Path, picture: bytes) -> None:
    assert "map.pgm: " in refusal(a_map(tmp_path, with_keys(), picture))


def test_sixteen_bits_keep_their_full_range(tmp_path: Path) -> None:
    file = tmp_path / "deep.pgm"
    file.write_bytes(b"P5\n3 1\n65535\n" + struct.pack(">3H", 0, 32768, 65535))
    assert read_shades(file).shade[0] == pytest.approx([0.0, 0.5, 1.0], abs=1e-4)


def test_the_saver_s_grey_is_doubtful_where_the_file_calls_it_free(tmp_path: Path) -> None:
    stored = read(a_map(tmp_path, with_keys(free_thresh=0.25)))
    assert cells(stored) == "#.."
    assert stored.doubtful[0].tolist() == [False, True, False]
    assert not read(a_map(tmp_path, with_keys())).doubtful.any()


def test_real_maps_have_the_cells_that_are_told_of_them() -> None:
    data = os.environ.get("ROVER_DATA")
    if not data:
        pytest.skip("ROVER_DATA is not set: the maps are not part of the project")
    assert read(Path(data) / "maps" / "depot.yaml").doubtful.sum() == 8894
    assert not read(Path(data) / "maps" / "tb3_sandbox.yaml").doubtful.any()
