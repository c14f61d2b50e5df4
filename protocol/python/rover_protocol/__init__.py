"""The rover's wire protocol, unchanged on CPython and MicroPython.

    from rover_protocol import framing, messages

    payload = messages.State.pack(state=messages.STATE_ARMED)     # raw integers; what is not given is 0
    wire = framing.encode(messages.State.ID, sequence, payload)   # bytes, ends with a zero

    decoder = framing.Decoder()
    for identifier, sequence, payload in decoder.feed(data):      # good frames only, the rest is counted
        message, values = messages.decode(identifier, payload)    # ValueError: unknown identifier, wrong length
        print(message.name, messages.physical(message, values))   # SI units

Tables of messages: `BY_ID`, `BY_NAME`, `SCALES[message][field]`, `VALUES[message][field][raw]`, `SCHEMA_HASH`,
and the names and numbers of each value table (`STATE_NAMES`, `STATE_MOVING`, `STATE_CAUSE_NAMES`, ...).
A `Message` has `name`, `ID`, `LENGTH`, `FIELDS` (names), `pack`, `unpack` (tuple), `decode` (dict). Counters of
a `Decoder`: `frames`, `checksum_errors`, `malformed`, `lost`.

A receiver that must not allocate (a microcontroller) uses `decoder.push(byte)` and
`message.unpack_into(payload, list)` instead of `feed` and `decode`; a sender `message.pack_into(buffer, values)`
and `framing.encode_into(...)`.
"""
