"""What a run leaves in its folder for people, programs and a next run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rover.mapping.map_server import map_files
from rover.mission.former_run import pack_run
from rover.mission.survey import Survey
from rover.mission.track import Track
from rover.record.tum import tum_lines
from rover.report.result import RunResult
from rover.report.write import write_or_tell, write_run


def write_outputs(result: RunResult, survey: Survey, track: Track) -> RunResult:
    """Writes all of them into `result.out`; what could not be written is named in the result that comes back."""
    out = Path(result.out)
    # What a next run goes on from comes first: the report can be made again, the drive cannot.
    lost = [write_or_tell(out / name, content) for name, content in pack_run(survey).items()]
    lost += [write_or_tell(out / name, content) for name, content in map_files(survey.perception.grid, "map").items()]
    lost += [write_or_tell(out / "trajectory.tum", tum_lines(track.fused).encode()), *write_run(result, out)]
    return replace(result, unwritten=tuple(line for line in lost if line is not None))
