"""`rover capture`: pictures of a source into a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rover.cli.output import say, write_json, write_text
from rover.cli.pictures import SOURCE, SOURCE_HELP
from rover.errors import BadInput

HELP = """Save the pictures of a source as PNG of 16 bits: a camera, a clip, the log of a run.

Files are 000001.png and on, kelvin × 100 where the source knows temperatures; frames behind the shutter are left out.
Without --count a file is saved to its end, a camera until Ctrl-C. The folder must not hold anything yet.

\b
Examples:
  rover capture v4l2:0 --out board --count 20 --preview      pictures of a board for `rover calibrate`
  rover capture clip.cptv --out frames
  rover capture runs/demo/log.mcap --out frames --count 100 --json
"""
PREVIEW = "preview"


def command(
    source: Annotated[str, typer.Argument(metavar=SOURCE, help=SOURCE_HELP)],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the pictures, new or empty.")],
    count: Annotated[int | None, typer.Option(min=1, metavar="N", help="So many pictures.")] = None,
    preview: Annotated[
        bool, typer.Option("--preview", help=f"Also 8 bits for the eye, in the folder {PREVIEW} of it.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> int:
    """See HELP."""
    from rover.capture.picture import write_picture
    from rover.cli.pictures import frames_of
    from rover.vision.registration.preprocess import contrast_limits, stretch

    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadInput(f"{out}: holds something already: name a new folder")
    saved = repeated = 0
    try:
        for frame in frames_of(source):
            if frame.ffc:
                repeated += 1
                continue
            saved += 1
            (out / PREVIEW if preview else out).mkdir(parents=True, exist_ok=True)
            name = f"{saved:06d}.png"
            write_picture(out / name, frame.counts)
            if preview:
                image = frame.counts.astype("float32")
                write_picture(out / PREVIEW / name, stretch(image, contrast_limits(image, (1.0, 99.0))))
            if saved == count:
                break
    except KeyboardInterrupt:
        say("ended by the operator")
    except OSError as error:
        raise BadInput(f"{out}: cannot be written: {error.strerror or error}") from error
    if saved == 0:
        raise BadInput(f"{source}: no picture came that could be saved")
    if repeated:
        say(f"{repeated} pictures behind the shutter left out")
    if count is not None and saved < count:
        say(f"{source} ended after {saved} of {count} pictures")
    if as_json:
        write_json({"frames": saved, "out": str(out), "preview": str(out / PREVIEW) if preview else None})
    else:
        write_text(f"{saved} pictures: {out}")
    return 0
