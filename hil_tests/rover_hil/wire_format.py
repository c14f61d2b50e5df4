"""The control socket's messages: u32 header length, u32 blob length (little-endian), header as JSON, blob."""

from __future__ import annotations

import json
import socket
import struct
from typing import Any

LENGTHS = struct.Struct("<II")
MAX_HEADER_BYTES = 16 * 1024 * 1024


class ClientGone(Exception):
    """The companion has closed its end."""


def receive(connection: socket.socket) -> dict[str, Any]:
    """The next request. Raises ClientGone at the end of the stream, ValueError for what is no request."""
    header_length, blob_length = LENGTHS.unpack(_exactly(connection, LENGTHS.size))
    if header_length > MAX_HEADER_BYTES or blob_length > MAX_HEADER_BYTES:
        raise ValueError(f"a message of {header_length} + {blob_length} bytes is too long")
    header = _exactly(connection, header_length)
    _exactly(connection, blob_length)
    request = json.loads(header)
    if not isinstance(request, dict):
        raise ValueError("a JSON object is expected")
    return request


def send(connection: socket.socket, header: dict[str, Any], blob: bytes = b"") -> None:
    """One reply. Raises ClientGone."""
    text = json.dumps(header, separators=(",", ":")).encode()
    try:
        connection.sendall(LENGTHS.pack(len(text), len(blob)) + text + blob)
    except OSError as error:
        raise ClientGone from error


def _exactly(connection: socket.socket, count: int) -> bytes:
    data = bytearray()
    while len(data) < count:
        try:
            part = connection.recv(count - len(data))
        except OSError as error:
            raise ClientGone from error
        if not part:
            raise ClientGone
        data += part
    return bytes(data)
