"""What a run leaves in its folder for people, programs and a next run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rover.mapping.map_server import map_files
from rover.mission.former_run import learned
from rover.mission.run_folder import JUDGEMENTS, RUN_FILES
from rover.mission.survey import Survey
from rover.mission.track import Track
from rover.record.manifest import MANIFEST, SIGNATURE, manifest_bytes, signature_bytes
from rover.record.tum import tum_lines
from rover.report.result import RunResult
from rover.report.write import write_or_tell, write_run

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey


def write_outputs(
    result: RunResult, survey: Survey, track: Track, key: Ed25519PrivateKey | None = None, pdf: bool = False
) -> RunResult:
    """Writes all of them into `result.out`, and last the manifest, signed with `key` if there is one.

    What could not be written is named in the result that comes back.
    """
    out = Path(result.out)
    # What a next run goes on from comes first: the report can be made again, the drive cannot.
    known = learned(survey)
    lost = [write_or_tell(out / name, content) for name, content in (known.packed() if known else {}).items()]
    lost += [write_or_tell(out / name, content) for name, content in map_files(survey.perception.grid, "map").items()]
    lost += [write_or_tell(out / "trajectory.tum", tum_lines(track.fused).encode()), *write_run(result, out, pdf)]
    lost += _seal(out, key)
    return replace(result, unwritten=tuple(line for line in lost if line is not None))


def _seal(out: Path, key: Ed25519PrivateKey | None) -> list[str | None]:
    try:
        # Judgements are added to afterwards.
        manifest = manifest_bytes(out, set(RUN_FILES) - {MANIFEST, SIGNATURE, JUDGEMENTS})
    except OSError as error:
        return [f"{out / MANIFEST} was not written: {error.strerror or error}"]
    lost = [write_or_tell(out / MANIFEST, manifest)]
    if key is not None:
        lost.append(write_or_tell(out / SIGNATURE, signature_bytes(manifest, key)))
    return lost
