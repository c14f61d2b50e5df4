"""A journal that holds what a replay does against what a log holds, message by message, in order."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from google.protobuf.json_format import MessageToDict
from google.protobuf.message import DecodeError, Message

from rover.record.difference import NOTHING, Difference, first_field, name_link_frame
from rover.record.journal import Journal, to_json
from rover.record.log_reader import Log, LogMessage
from rover.record.topics import FED, LINK_RECEIVED, LINK_SENT


class Differs(Exception):
    """The replay has left the recording; what follows could not be compared."""


class RecordingOver(Exception):
    """A log that was cut short has come to its end."""


class Comparison(Journal):
    """Compares every message but the inputs that were fed. `messages` counts the equal ones.

    Raises Differs at the first difference, which is then in `difference`; RecordingOver at the end of a cut log.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self.epoch = log.epoch
        self._recorded: Iterator[LogMessage] = log.messages(without=FED)
        self.messages = 0
        self.difference: Difference | None = None

    def put_protobuf(self, topic: str, time: float, message: Message) -> None:
        """See Journal."""
        if topic not in FED:
            self._compare(topic, time, message.SerializeToString(deterministic=True), type(message))

    def put_json(self, topic: str, time: float, content: Mapping[str, Any], kind: type | None) -> None:
        """See Journal."""
        if topic not in FED:
            self._compare(topic, time, to_json(content).encode(), None)

    def put_bytes(self, topic: str, time: float, data: bytes) -> None:
        """See Journal: bytes are inputs of other parts."""

    def finish(self) -> None:
        """To be called when the replay has come to its end: the recording must be at its end too."""
        left = next(self._recorded, None)
        if left is not None and self.difference is None:
            self._found(Difference(left.topic, left.time_ns * 1e-9, "message", _shown(left), NOTHING))

    def _compare(self, topic: str, time: float, data: bytes, kind: type[Message] | None) -> None:
        recorded = next(self._recorded, None)
        time_ns = round(time * 1e9)
        replayed = LogMessage(topic, time_ns, data)
        if recorded is None:
            if self._log.cut:
                raise RecordingOver
            self._found(Difference(topic, time, "message", NOTHING, _shown(replayed, kind)))
        elif recorded.topic != topic:
            at = min(recorded.time_ns, time_ns) * 1e-9
            self._found(Difference(topic, at, "message", _shown(recorded), _shown(replayed, kind)))
        elif recorded.data != data:
            found = first_field(_plain(recorded, kind), _plain(replayed, kind))
            field, before, now = found or ("bytes", recorded.data.hex(), data.hex())
            self._found(Difference(topic, time, field, before, now))
        elif recorded.time_ns != time_ns:
            self._found(Difference(topic, time, "log_time", recorded.time_ns * 1e-9, time))
        self.messages += 1

    def _found(self, difference: Difference) -> None:
        self.difference = difference
        raise Differs


def _plain(message: LogMessage, kind: type[Message] | None) -> Any:
    """The message as JSON values; frames of the link by their names."""
    if kind is not None:
        try:
            return MessageToDict(kind.FromString(message.data), preserving_proto_field_name=True)
        except DecodeError:
            return message.data.hex()
    try:
        content = json.loads(message.data)
    except ValueError:
        return f"{len(message.data)} bytes"
    return name_link_frame(content) if message.topic in (LINK_SENT, LINK_RECEIVED) else content


def _shown(message: LogMessage, kind: type[Message] | None = None) -> str:
    content = _plain(message, kind)
    text = content if isinstance(content, str) else to_json(content)
    return f"{message.topic} {text if len(text) <= 160 else text[:157] + '…'}"
