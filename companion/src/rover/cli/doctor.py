"""`rover doctor`: what is installed, and what is connected."""

from __future__ import annotations

import importlib
import importlib.metadata
import logging
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from rover import plugins
from rover.cli.output import write_json, write_text
from rover.errors import PreflightFailed, RoverError
from rover.link.baud import DEFAULT_BAUD

HELP = """Check what is installed and what is connected; exit code 3 when something that a mission needs is missing.

\b
Examples:
  rover doctor
  rover doctor --port /dev/ttyACM0          also shakes hands with the firmware
  rover doctor --port can:socketcan:can0    the same over a CAN bus
  rover doctor --json | jq '.checks[] | select(.ok | not)'
"""
OLDEST_PYTHON = (3, 10)
# Modules that missions import, each with the distribution it comes in.
PACKAGES = (
    ("numpy", "numpy"),
    ("cv2", "opencv-python-headless"),
    ("onnxruntime", "onnxruntime"),
    ("ruckig", "ruckig"),
    ("serial", "pyserial"),
    ("can", "python-can"),
    ("mcap", "mcap"),
)

NATIVE = "rover_native"
# Those of python-can's interfaces that can tell what is plugged in. An slcan adapter shows as a serial port.
CAN_INTERFACES = ("socketcan", "gs_usb", "pcan", "kvaser")

FIRMWARE_TARGET = "thumbv6m-none-eabi"


@dataclass(frozen=True)
class Check:
    """One line of the examination; `ok` is False only for something that is needed."""

    name: str
    ok: bool
    detail: str


def command(
    port: Annotated[
        str | None, typer.Option(metavar="P", help="Also ask the firmware on this port, see rover status.")
    ] = None,
    baud: Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")] = DEFAULT_BAUD,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    checks = examine(port, baud)
    if as_json:
        write_json({"checks": [asdict(check) for check in checks]})
    else:
        width = max(len(check.name) for check in checks)
        write_text("\n".join(f"{'ok' if c.ok else 'FAILED':<7}{c.name:<{width + 2}}{c.detail}" for c in checks))
    return 0 if all(check.ok for check in checks) else PreflightFailed.exit_code


def examine(port: str | None = None, baud: int = DEFAULT_BAUD) -> list[Check]:
    """Every check, in a fixed order; none of them raises."""
    checks = [_python()]
    checks += [_guarded(module, partial(_package, module, name)) for module, name in PACKAGES]
    checks += [_guarded(NATIVE, _native), _guarded("model", _model), *_rigs()]
    checks += [
        Check("firmware toolchain", True, _optional(_toolchain)),
        Check("serial ports", True, _optional(_ports)),
        Check("cameras", True, _optional(_cameras)),
        Check("CAN interfaces", True, _optional(_can_interfaces)),
    ]
    if port is not None:
        checks.append(_guarded("firmware", lambda: _firmware(port, baud)))
    return checks


def _guarded(name: str, find: Callable[[], str]) -> Check:
    try:
        return Check(name, True, find())
    except RoverError as error:
        return Check(name, False, str(error))
    except Exception as error:  # a broken installation may raise anything, and that is what is asked for
        return Check(name, False, f"{type(error).__name__}: {' '.join(str(error).split())}")


def _optional(find: Callable[[], str]) -> str:
    return _guarded("", find).detail


def _python() -> Check:
    version = ".".join(map(str, sys.version_info[:3]))
    if sys.version_info < OLDEST_PYTHON:
        return Check("python", False, f"{version}; 3.10 or newer is needed")
    return Check("python", True, f"{version} at {sys.executable}")


def _package(module: str, distribution: str) -> str:
    try:
        loaded = importlib.import_module(module)
    except ImportError as error:
        raise PreflightFailed(f"cannot be imported ({error}): run 'make setup'") from error
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return str(getattr(loaded, "__version__", "unknown version"))


def _native() -> str:
    try:
        loaded = importlib.import_module(NATIVE)
    except ImportError as error:
        raise PreflightFailed(f"not built ({error}): run 'make setup'") from error
    return str(loaded.__file__)


def _model() -> str:
    from rover.detection.classifier import LENGTHS, Classifier, default_model

    loaded = [Classifier(default_model(kind), kind) for kind in LENGTHS]
    return "; ".join(f"{Path(each.path).name}, sha256 {each.sha256}" for each in loaded)


def _rigs() -> list[Check]:
    """What the simulated rigs say of themselves. A rover in the field does not need them."""
    names = plugins.names(plugins.CHECKS)
    if not names:
        return [Check("simulated rigs", True, f"{plugins.missing('rover run --rig sitl')}; a real rover needs none")]
    return [_guarded(name, partial(_plugged, name)) for name in names]


def _plugged(name: str) -> str:
    check: Callable[[], str] = plugins.load(plugins.CHECKS, name)
    return check()


def _toolchain() -> str:
    compiler = shutil.which("rustc")
    if compiler is None or shutil.which("cargo") is None:
        return "no Rust here; only needed to build the firmware"
    version = _said(compiler, "--version")
    if not version:
        return "Rust is installed but has no default toolchain; only needed to build the firmware"
    libraries = Path(_said(compiler, "--print", "sysroot")) / "lib" / "rustlib" / FIRMWARE_TARGET
    board = FIRMWARE_TARGET if libraries.is_dir() else f"{FIRMWARE_TARGET} is not installed; make firmware adds it"
    return f"{version}, {board}"


def _said(*line: str) -> str:
    return subprocess.run(line, capture_output=True, text=True, timeout=10.0, check=False).stdout.strip()


def _ports() -> str:
    from serial.tools import list_ports

    # Linux lists a /dev/ttyS* for every UART that could be there; those without hardware have no description.
    found = [port for port in list_ports.comports() if port.hwid != "n/a"]
    return ", ".join(f"{port.device} ({port.description})" for port in sorted(found)) or "none seen"


def _cameras() -> str:
    from rover.capture.devices import list_cameras

    return ", ".join(f"{camera.device} ({camera.name})" for camera in list_cameras()) or "none seen"


def _can_interfaces() -> str:
    import can

    logging.getLogger("can").setLevel(logging.CRITICAL)  # a driver that is not installed is no news here
    found = can.detect_available_configs(CAN_INTERFACES)
    return ", ".join(sorted(f"can:{each['interface']}:{each['channel']}" for each in found)) or "none seen"


def _firmware(port: str, baud: int) -> str:
    from rover.cli.asking import ask_politely

    told = ask_politely(port, baud)
    mission = f"; a mission drives it: {told['mission']['says']}" if "mission" in told else ""
    return f"{told['firmware']} ({told['git_hash']}) on {told['board']}: {told['meaning']}{mission}"
