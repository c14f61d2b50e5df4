"""Who is at the other end, and whether it speaks the same protocol."""

from __future__ import annotations

from dataclasses import dataclass

from rover_protocol import messages

from rover.errors import PreflightFailed


@dataclass(frozen=True)
class Identity:
    """What the firmware says of itself."""

    version: str
    board: str
    git_hash: str
    reset_cause: str
    schema_hash: int


class Handshake:
    """Collects the answers to Hello. Raises PreflightFailed when the schemas differ."""

    def __init__(self, session: int) -> None:
        self.session = session
        self._reply: dict[str, int] | None = None
        self._build: dict[str, int] | None = None
        self.busy: str | None = None
        """Who drives the rover, while that is another session: ask again."""

    @property
    def done(self) -> bool:
        """True when both answers are there."""
        return self._reply is not None and self._build is not None

    def take(self, name: str, fields: dict[str, int | bytes]) -> bool:
        """True when the message belonged to the handshake."""
        if name == "HelloReply":
            self._reply = {key: int(value) for key, value in fields.items()}
            theirs = self._reply["schema_hash"]
            if theirs != messages.SCHEMA_HASH:
                raise PreflightFailed(
                    f"the firmware speaks another protocol: its schema hash is 0x{theirs:08x}, this companion's is "
                    f"0x{messages.SCHEMA_HASH:08x}; flash the firmware of this version (make firmware)"
                )
            return True
        if name == "HelloBuild":
            build = {key: int(value) for key, value in fields.items()}
            if build["session"] == self.session:
                if self.busy is not None and not build["accepted"]:
                    return True
                if not build["accepted"]:
                    raise PreflightFailed(
                        "the firmware refuses the handshake: it holds this companion's schema hash "
                        f"0x{messages.SCHEMA_HASH:08x} for another than its own"
                    )
                self._build, self.busy = build, None
            return True
        if name == "HelloBusy":
            if fields["session"] == self.session:
                wire = messages.VALUES["HelloBusy"]["wire"].get(int(fields["wire"]), "another wire")
                self.busy = f"busy: session 0x{int(fields['holder']):04x} drives the rover over {wire}"
            return True
        return False

    def identity(self) -> Identity:
        """Call when `done`."""
        assert self._reply is not None
        assert self._build is not None
        reply, build = self._reply, self._build
        values = messages.VALUES
        return Identity(
            version=f"{reply['version_major']}.{reply['version_minor']}.{reply['version_patch']}",
            board=values["HelloReply"]["board"].get(reply["board"], f"Unknown{reply['board']}"),
            git_hash=f"{build['git_hash']:08x}",
            reset_cause=values["HelloBuild"]["reset_cause"].get(build["reset_cause"], "Unknown"),
            schema_hash=reply["schema_hash"],
        )
