"""A wire around another one: everything is the inner one's, but for what a subclass does differently."""

from __future__ import annotations

from rover.link.frames import Counters, FrameTransport
from rover.link.transport import Transport


class _Around:
    """What a wire of either kind hands on."""

    inner: Transport | FrameTransport

    @property
    def bytes_written(self) -> int:
        """Of the inner wire."""
        return self.inner.bytes_written

    @property
    def bytes_read(self) -> int:
        """Of the inner wire."""
        return self.inner.bytes_read

    def close(self) -> None:
        """Lets the inner wire go; what is on its way is lost."""
        self.inner.close()


class BytesAround(_Around):
    """A transport of bytes; `write` and `read` are the subclass's."""

    inner: Transport

    def __init__(self, inner: Transport) -> None:
        self.inner = inner
        self.port, self.byte_time, self.time_step, self.lead = inner.port, inner.byte_time, inner.time_step, inner.lead


class WireAround(_Around, FrameTransport):
    """A wire of frames; `send` and `receive` are the subclass's."""

    inner: FrameTransport

    def __init__(self, inner: FrameTransport) -> None:
        self.inner = inner
        self.port, self.time_step = inner.port, inner.time_step

    @property
    def counters(self) -> Counters:
        """Of the inner wire."""
        return self.inner.counters

    def wire_bytes(self, payload: int) -> float:
        """Of the inner wire."""
        return self.inner.wire_bytes(payload)

    def wire_times(self, request: int, reply: int) -> tuple[float, float]:
        """Of the inner wire: a delay that is added around it is one that the session has to cope with."""
        return self.inner.wire_times(request, reply)
