"""What run.mjs executes on MicroPython: the golden vectors, and that receiving allocates nothing."""

import gc
import json
import sys

from rover_protocol import framing, messages

assert sys.implementation.name == "micropython", sys.implementation.name


def load(name):
    with open(name) as file:
        return json.load(file)


vectors = load("/messages.json")
for vector in vectors:
    message = messages.BY_NAME[vector["message"]]
    payload = bytes.fromhex(vector["payload"])
    values = {name: bytes(v) if isinstance(v, list) else v for name, v in vector["values"].items()}
    assert message.pack(**values) == payload, vector
    assert messages.decode(vector["identifier"], payload) == (message, values), vector
    frame = framing.encode(message.ID, vector["sequence"], payload)
    assert frame == bytes.fromhex(vector["frame"]), vector
print("messages", len(vectors))

streams = load("/streams.json")
for stream in streams:
    decoder = framing.Decoder()
    # MicroPython: b"".hex() is b"", not "".
    frames = [[i, s, p.hex() if p else ""] for i, s, p in decoder.feed(bytes.fromhex(stream["input"]))]
    assert frames == stream["frames"], (stream["name"], frames)
    for counter in ("checksum_errors", "malformed", "lost"):
        assert getattr(decoder, counter) == stream[counter], (counter, stream)
print("streams", len(streams))


def receive(decoder, data, values):
    """The steady-state path of a node: bytes in, raw values out."""
    count = 0
    for position in range(len(data)):
        if decoder.push(data[position]):
            message = messages.BY_ID[decoder.identifier]
            message.unpack_into(decoder.payload, values)
            count += 1
    return count


# Texts and integers beyond 30 bits cannot be had without allocating here: LogText is left out, the rest is zero.
quiet = [v for v in vectors if v["case"] == "zero" and v["message"] != "LogText"]
data = b"".join([bytes.fromhex(v["frame"]) for v in quiet])
decoder = framing.Decoder()
values = [0] * 8
receive(decoder, data, values)
gc.collect()
gc.disable()
before = gc.mem_alloc()
received = receive(decoder, data, values)
print("allocated", gc.mem_alloc() - before, "bytes for", received, "frames")
