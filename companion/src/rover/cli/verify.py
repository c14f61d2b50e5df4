"""`rover verify`: a run's folder against its manifest."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rover.cli.output import write_json, write_text

if TYPE_CHECKING:
    from rover.record.manifest import Verified

HELP = """Hold a run's folder against its manifest: is every file as the run left it, and who signed?

A run writes manifest.json with the SHA-256 of each of its files, and manifest.sig when it was given a key (rover run
--key). Exit code 0 when all is as it was, 3 when a file is missing or has changed, or the signature does not fit.
Files that came later, such as an operator's judgements, are listed and change nothing.

\b
Examples:
  rover verify runs/morning
  rover verify runs/morning --public-key operator.pub
  rover verify runs/morning --json | jq '.files[] | select(.ok | not)'
  openssl genpkey -algorithm ed25519 -out operator.pem    makes a key
  openssl pkey -in operator.pem -pubout -out operator.pub
"""

CHANGED = 3


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run.")],
    public_key: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The key that must have signed, PEM or OpenSSH.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.errors import BadInput
    from rover.record import manifest

    if not run.is_dir():
        raise BadInput(f"{run}: no such folder of a run")
    if not (run / manifest.MANIFEST).exists():
        raise BadInput(f"{run}: no {manifest.MANIFEST} is there: not a run that came to its end, or an older one")
    found = manifest.verify(run, None if public_key is None else manifest.public_key(public_key))
    if as_json:
        files = [{"name": file.name, "ok": file.ok, "why": file.why} for file in found.files]
        write_json({"ok": found.ok, **asdict(found), "files": files})
    else:
        write_text(_text(found))
    return 0 if found.ok else CHANGED


def _text(found: Verified) -> str:
    lines = [f"{'ok' if file.ok else 'FAILED':<7}{file.name} {file.why}".rstrip() for file in found.files]
    lines += [f"{'later':<7}{name}" for name in found.added]
    if found.signature == "none":
        lines.append("not signed: damage would show, a change of a file and its hash together would not")
    else:
        lines.append(f"signature {found.signature}" + (f", by the key {found.key}" if found.key else ""))
    if found.trusted is not None:
        lines.append("by the key that was asked for" if found.trusted else "NOT by the key that was asked for")
    return "\n".join(lines)
