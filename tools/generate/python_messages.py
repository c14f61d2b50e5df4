"""Render protocol/python/rover_protocol/messages.py, which must also run on MicroPython."""

from __future__ import annotations

from tools.generate.schema import Schema, snake, table_name

HEADER = '''"""Messages of protocol/rover.dbc, raw integers as on the wire.

Written by `python -m tools.generate`: change the DBC, not this file.
"""

from rover_protocol.message import Message
'''

FOOTER = '''

def decode(identifier: int, payload: bytes | bytearray) -> tuple[Message, dict[str, int | bytes]]:
    """(Message, {field: raw value}) of a received frame.

    Raises ValueError for an unknown identifier or a payload of the wrong length.
    """
    message = BY_ID.get(identifier)
    if message is None:
        raise ValueError(f"unknown identifier 0x{identifier:03x}")
    return message, message.decode(payload)


def physical(message: Message, values: dict[str, int | bytes]) -> dict[str, int | float | bytes]:
    """The raw `values` of decode() in SI units, as the DBC scales them; texts stay bytes."""
    scales = SCALES.get(message.name, {})
    return {
        name: value * scales[name] if name in scales and not isinstance(value, bytes) else value
        for name, value in values.items()
    }
'''


def number(factor: float) -> str:
    text = f"{factor:.12g}"
    return text if any(c in text for c in ".e") else text + ".0"


def render(schema: Schema) -> str:
    """The whole file."""
    lines = [HEADER, f"SCHEMA_HASH = 0x{schema.hash:08X}", ""]
    for message in schema.messages:
        fields = ", ".join(f'("{f.name}", {f.start}, {f.size}, {f.signed})' for f in message.fields)
        lines.append(f"# {message.comment}")
        identity = f'"{message.name}", 0x{message.identifier:03X}, {message.length}'
        lines.append(f"{message.name} = Message({identity}, ({fields},))")
    lines += ["", "BY_ID = {"]
    lines += [f"    0x{m.identifier:03X}: {m.name}," for m in schema.messages]
    lines += ["}", "BY_NAME = {message.name: message for message in BY_ID.values()}", ""]
    lines.append("# Physical value = raw value * scale; fields that are not here are plain counts and codes.")
    lines.append("SCALES: dict[str, dict[str, float]] = {")
    for message in schema.messages:
        scaled = [f for f in message.fields if f.factor != 1]
        if scaled:
            entries = ", ".join(f'"{f.name}": {number(f.factor)}' for f in scaled)
            lines.append(f'    "{message.name}": {{{entries}}},')
    lines += ["}", ""]
    tables = [(m, f, table_name(m, f).upper()) for m in schema.messages for f in m.fields if f.values]
    for message, field, table in tables:
        lines.append(f"# {message.name}.{field.name}")
        lines += [f"{table}_{snake(name).upper()} = {raw}" for raw, name in field.values]
        names = ", ".join(f'{raw}: "{name}"' for raw, name in field.values)
        lines += [f"{table}_NAMES = {{{names}}}", ""]
    lines.append('# Value tables by message and field: VALUES["State"]["cause"][4] == "DeadMan".')
    lines.append("VALUES: dict[str, dict[str, dict[int, str]]] = {")
    for message in schema.messages:
        named = [f'"{f.name}": {t}_NAMES' for m, f, t in tables if m is message]
        if named:
            lines.append(f'    "{message.name}": {{{", ".join(named)}}},')
    lines.append("}")
    return "\n".join(lines) + "\n" + FOOTER
