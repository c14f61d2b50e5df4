"""`rover flash`: a new firmware for the board, and what it says of itself once it runs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rover.cli.output import say, write_json, write_text
from rover.errors import BadInput, LinkLost, PreflightFailed
from rover.link.baud import DEFAULT_BAUD

if TYPE_CHECKING:
    from rover.cli.probe import Answer
    from rover.link.boot_drive import BootDrive
    from rover.link.self_test import Finding
    from rover.link.uf2 import Uf2

HELP = """Write the firmware to the board, wait for it to come up, and print its version and self-test.

Takes the drive of a board in its boot loader (hold BOOTSEL while plugging it in); or tells a running rover to start
its boot loader; or uses a debug probe through probe-rs. Exit code 3 when there is no board, when what came up
fails its self-test, or when its board or commit are not those of the file.

\b
Examples:
  rover flash                                      firmware/build of this repository, to the board that is there
  rover flash --port /dev/ttyAMA0                  a rover that runs: no button has to be pressed
  rover flash --drive /mnt/pico --file rover.uf2
  rover flash --json | jq '.self_test[] | select(.ok | not)'
"""

# Where `make firmware` puts it, in a checkout.
BUILT = Path(__file__).resolve().parents[4] / "firmware" / "build"

CHIPS = {"RP2040": "RP2040", "RP2350": "RP235x"}


def command(
    port: Annotated[str | None, typer.Option(metavar="P", help="The rover's port, see rover status.")] = None,
    file: Annotated[Path | None, typer.Option(metavar="UF2", help="The firmware.  [default: what was built]")] = None,
    drive: Annotated[Path | None, typer.Option(metavar="DIR", help="Where the boot loader's drive is mounted.")] = None,
    baud: Annotated[int, typer.Option(min=1200, max=4_000_000, help="Bit rate of a serial port.")] = DEFAULT_BAUD,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.link.flashing import wait_for_port

    firmwares = _firmwares(file)
    way, firmware, port = _write(firmwares, port, drive, baud)
    say("written; waiting for the new firmware")
    named = port
    port = wait_for_port(named)
    if port is None:
        raise PreflightFailed(
            f"{firmware.path} is written, and no rover has come up on {named or 'any USB port'}: if its link is a UART "
            "or a bus, ask it with rover status --port P"
        )
    answer, findings = _ask(port, baud)
    _compare(firmware, answer, port)
    told = _document(firmware, way, port, answer, findings)
    write_json(told) if as_json else write_text(_text(told))
    return 0 if all(finding.ok for finding in findings) else PreflightFailed.exit_code


def _firmwares(file: Path | None) -> list[Uf2]:
    """What there is to be written; several when boards of several kinds were built for."""
    from rover.link.uf2 import read_uf2

    if file is not None:
        return [read_uf2(file)]
    built = sorted(BUILT.glob("*.uf2"))
    if not built:
        raise BadInput("no firmware is built: run 'make firmware', or name a file with --file")
    return [read_uf2(path) for path in built]


def _write(firmwares: list[Uf2], port: str | None, folder: Path | None, baud: int) -> tuple[str, Uf2, str | None]:
    """Finds the board and writes; returns over which way, which firmware, and the port to ask afterwards."""
    from rover.cli.progress import progress
    from rover.link import boot_drive, flashing

    patterns = boot_drive.MOUNT_PATTERNS
    found = flashing.choose_drive(folder, patterns)
    if found is None and (running := port or flashing.choose_port()) is not None:
        say(f"telling the rover on {running} to start its boot loader")
        flashing.into_bootloader(running, baud)
        found = flashing.wait_for_drive(folder, patterns)
    if found is not None:
        firmware = _fitting(firmwares, found)
        board = found.model or found.board_id
        say(f"writing {firmware.path.name}, {firmware.blocks} blocks, to the {board} on {found.folder}")
        with progress("bytes") as told:
            boot_drive.write(found, firmware, told)
        return str(found.folder), firmware, port
    if flashing.has_probe():
        (firmware,) = firmwares if len(firmwares) == 1 else [f for f in firmwares if f.family_names == "RP2040"]
        flashing.flash_by_probe(firmware.path, CHIPS.get(firmware.family_names, firmware.family_names), say)
        return "probe-rs", firmware, port
    if folder is not None:
        raise PreflightFailed(f"--drive {folder}: no {boot_drive.INFO_FILE} there, so no board in its boot loader")
    raise PreflightFailed(flashing.not_mounted() or flashing.NOTHING_FOUND)


def _fitting(firmwares: list[Uf2], drive: BootDrive) -> Uf2:
    """The firmware for the board; the first when none fits, for `write` to refuse it by name."""
    return next((firmware for firmware in firmwares if drive.takes(firmware)), firmwares[0])


def _ask(port: str, baud: int, patience: float = 10.0) -> tuple[Answer, list[Finding]]:
    """Handshake and self-test. A port may be there before the firmware behind it answers."""
    import time

    from rover.cli.probe import ask
    from rover.link.self_test import self_test

    deadline = time.monotonic() + patience
    while True:
        try:
            answer = ask(port, baud)
            return answer, self_test(answer.state, answer.battery, answer.sonars)
        except (PreflightFailed, LinkLost):
            if time.monotonic() > deadline:
                raise


def _compare(firmware: Uf2, answer: Answer, port: str) -> None:
    """Whether it is the new firmware that has answered. Raises PreflightFailed when it is not."""
    mark, identity = firmware.mark, answer.identity
    if mark is None:
        raise PreflightFailed(
            f"{firmware.path} is written and carries no mark of a rover's firmware: what answers on {port} "
            f"({identity.board}, commit {identity.git_hash}) cannot be compared with it"
        )
    if (identity.board, identity.git_hash) != (mark.board, mark.git_hash):
        raise PreflightFailed(
            f"{firmware.path} is for {mark.board}, commit {mark.git_hash}, and what answers on {port} is "
            f"{identity.board}, commit {identity.git_hash}: another board, or one that does not run what was written"
        )


def _document(firmware: Uf2, way: str, port: str, answer: Answer, findings: list[Finding]) -> dict[str, Any]:
    """For JSON."""
    identity = answer.identity
    return {
        "file": str(firmware.path),
        "for": firmware.family_names,
        "bytes": len(firmware.content),
        "written_to": way,
        "port": port,
        "firmware": identity.version,
        "git_hash": identity.git_hash,
        "board": identity.board,
        "reset_cause": identity.reset_cause,
        "schema_hash": f"{identity.schema_hash:08x}",
        "self_test": [asdict(finding) for finding in findings],
    }


def _text(told: dict[str, Any]) -> str:
    """For a person."""
    head = f"firmware {told['firmware']} ({told['git_hash']}) on {told['board']}, {told['port']}"
    rows = [f"{'ok' if each['ok'] else 'FAILED':<7}{each['name']:<16}{each['detail']}" for each in told["self_test"]]
    return "\n".join([head, *rows])
