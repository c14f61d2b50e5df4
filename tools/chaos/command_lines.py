"""Every command that takes a file, with what would be right in its place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, PublicFormat

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "docs" / "examples"
CAMERAS = ROOT / "companion" / "src" / "rover" / "cameras"
SCENARIO = ROOT / "hil_tests" / "scenarios" / "noise-instead-of-frames.toml"
FRAME = EXAMPLES / "frames" / "00.png"

# In a line IT stands for the hostile file, PICTURE, PATH, MISSION and RUN for right ones, OUT for what is written.


@dataclass(frozen=True)
class Line:
    """suffixes: what the file may be called; right: contents that would do in its place."""

    words: tuple[str, ...]
    right: tuple[bytes, ...]
    suffixes: tuple[str, ...]


def _line(words: str, suffixes: str, *right: Path | bytes) -> Line:
    contents = tuple(each if isinstance(each, bytes) else each.read_bytes() for each in right)
    return Line(tuple(words.split()), contents, tuple(suffixes.split()) or ("",))


FRAMES = tuple(sorted((EXAMPLES / "frames").glob("*.png")))
PICTURES = (*FRAMES, EXAMPLES / "thermal.jpg")
MAP = EXAMPLES / "paper_map.toml"
CAMERA = CAMERAS / "lepton-160.toml"
MISSION = EXAMPLES / "mission.toml"
VEHICLE = ROOT / "companion" / "src" / "rover" / "vehicle" / "example.toml"
WAY = b"[[0, 0], [1, 0], [1, 1.5], [0.2, 1.5]]"
GROUND = b"u,v,x,y\n80,100,0.6,0.0\n20,100,0.6,0.2\n140,100,0.6,-0.2\n80,70,0.9,0.0\n30,70,0.9,0.3\n130,70,0.9,-0.3\n"
OCCUPANCY = (
    b"image: picture.png\nresolution: 0.05\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
    b"occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n"
)
PARAMETERS = b"[parameters]\nsonar_slot = 40\ntrack = 150000\ndead_man = 300\n"
_KEY = Ed25519PrivateKey.from_private_bytes(bytes(range(32)))
PRIVATE_KEY = _KEY.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
PUBLIC_KEY = _KEY.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
MOVING_AI = b"type octile\nheight 4\nwidth 6\nmap\n......\n..@@..\n..@@..\n......\n"

LINES = (
    _line("plan --map IT --start 2,0.5 --goal 2,2.5 --seed 1", ".toml", MAP),
    _line("plan --map IT --start 0.5,0.5 --goal 1,1 --seed 1", ".yaml", OCCUPANCY),
    _line("plan --map IT --start 0.5,0.5 --goal 1,1 --seed 1", ".map", MOVING_AI),
    _line("trajectory IT", ".json", WAY),
    _line("trajectory PATH --map IT", ".toml .yaml .map", MAP),
    _line("decode IT", ".jpg .tif .tiff .png .seq .cptv", *PICTURES),
    _line("decode IT --tiff OUT.tif", ".jpg .tif", *PICTURES),
    _line("register PICTURE IT --json", ".png .jpg .tif .pgm .bmp", *PICTURES),
    _line("stitch PICTURE IT --out OUT.png", ".png .jpg .tif", *PICTURES),
    _line("detect IT --json", ".png .jpg .tif", *PICTURES),
    _line("detect PICTURE --camera IT", ".toml", CAMERA),
    _line("track IT --camera lepton-160", ".png .jpg .mp4 .seq", *PICTURES),
    _line("track PICTURE --camera IT --ground-plane", ".toml", CAMERA),
    _line("grid IT --out OUT.yaml", ".png .jpg .tif", *PICTURES),
    _line("calibrate IT --board 5x4 --square 0.1", ".png .jpg", *PICTURES),
    _line("calibrate --camera lepton-160 --ground IT", ".csv", GROUND),
    _line("locate --camera IT --pixel 80,100", ".toml", CAMERA),
    _line("capture IT --out OUT --count 1", ".png .mp4 .seq .cptv .mcap", *PICTURES),
    _line("when IT", ".toml", EXAMPLES / "site.toml"),
    _line("run IT --out OUT --quiet --rig device --port /dev/nowhere", ".toml", MISSION),
    _line("run IT --out OUT --quiet --rig device", ".toml", MISSION),
    _line("hil run IT", ".toml", SCENARIO),
    _line("flash --file IT --drive OUT", ".uf2", *FRAMES),
    _line("tell IT state", "", *FRAMES),
    _line("compare IT IT --json", "", *FRAMES),
    _line("verify IT", "", *FRAMES),
    _line("verify RUN --public-key IT", ".pub .pem", PUBLIC_KEY),
    _line("run MISSION --out OUT --quiet --rig device --port /dev/nowhere --key IT", ".pem", PRIVATE_KEY),
    _line("param set --file IT --port /dev/nowhere", ".toml", PARAMETERS),
    _line("vehicle push --vehicle IT --port /dev/nowhere", ".toml", VEHICLE),
    _line("vehicle diff --vehicle IT --port /dev/nowhere --json", ".toml", VEHICLE),
    _line("bringup --vehicle IT --port /dev/nowhere --yes", ".toml", VEHICLE),
    _line("monitor --port IT --seconds 2 --json", "", *FRAMES),
)
"""Those that read a run are in `damaged_runs`."""
