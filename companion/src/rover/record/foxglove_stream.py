"""What a run writes down, live to Foxglove: the messages of the log, as they are, to whoever has subscribed.

Sending is the business of the library's own threads with queues of their own: the mission hands bytes over and goes on.
Comes with the extra [foxglove].
"""

from __future__ import annotations

from typing import Any

from rover.errors import BadInput, PreflightFailed

HOST = "127.0.0.1"
# Messages that a slow viewer may be behind before it misses some.
BACKLOG = 256


class FoxgloveStream:
    """A server while the block runs; `url` is what to open in Foxglove."""

    def __init__(self, port: int, name: str) -> None:
        """port: 0 takes a free one. Raises PreflightFailed without the library, BadInput for a port that is taken."""
        try:
            import foxglove
        except ImportError:
            raise PreflightFailed(
                "--foxglove needs the package foxglove-sdk: install the extra [foxglove], as by 'make setup-foxglove'"
            ) from None
        self._library: Any = foxglove
        self._channels: dict[str, Any] = {}
        # Its own: a second run of the same process has the same topics.
        self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name=name, host=HOST, port=port, message_backlog_size=BACKLOG, context=self._context
            )
        except (RuntimeError, OSError, ValueError) as error:
            raise BadInput(f"--foxglove-port {port}: {error}") from error
        self.url = f"ws://{HOST}:{self._server.port}"

    def open(self, topic: str, encoding: str, schema: tuple[str, str, bytes] | None) -> None:
        """A topic that messages will come on. schema: its name, encoding and text; None for bytes of our own."""
        described = self._library.Schema(name=schema[0], encoding=schema[1], data=schema[2]) if schema else None
        self._channels[topic] = self._library.Channel(
            topic, message_encoding=encoding, schema=described, context=self._context
        )

    def publish(self, topic: str, stamp: int, data: bytes) -> None:
        """One message, `stamp` in nanoseconds; nothing when nobody has subscribed."""
        channel = self._channels[topic]
        if channel.has_sinks():
            channel.log(data, log_time=stamp)

    def __enter__(self) -> FoxgloveStream:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.stop()
