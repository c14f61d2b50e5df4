"""Render protocol/rust/src/messages.rs. The text is what rustfmt would make of it."""

from __future__ import annotations

from tools.generate.schema import Field, Layout, Schema, snake

HEADER = """//! Messages of `protocol/rover.dbc`, raw integers as on the wire.
//!
//! Written by `python -m tools.generate`: change the DBC, not this file. A 24-bit field is held in 32 bits;
//! its upper byte is dropped by `write` and restored by sign extension in `read`.

use crate::Message;
"""


def rust_type(field: Field) -> str:
    if field.size > 4:
        return f"[u8; {field.size}]"
    width = {1: 8, 2: 16, 3: 32, 4: 32}[field.size]
    return f"{'i' if field.signed else 'u'}{width}"


def read_expression(field: Field) -> str:
    p = [f"p[{i}]" for i in range(field.start, field.start + field.size)]
    kind = rust_type(field)
    if field.size > 4:
        return f"[{', '.join(p)}]"
    if field.size == 1 and not field.signed:
        return p[0]
    if field.size == 3:
        if field.signed:
            return f"i32::from_le_bytes([0, {', '.join(p)}]) >> 8"
        return f"u32::from_le_bytes([{', '.join(p)}, 0])"
    return f"{kind}::from_le_bytes([{', '.join(p)}])"


def write_statement(field: Field) -> str:
    b = [f"b{i}" for i in range(field.start, field.start + field.size)]
    if field.size > 4:
        return f"let [{', '.join(b)}] = self.{field.name};"
    if field.size == 1 and not field.signed:
        return f"let {b[0]} = self.{field.name};"
    if field.size == 3:
        b.append("_")
    return f"let [{', '.join(b)}] = self.{field.name}.to_le_bytes();"


def field_comment(field: Field) -> str:
    parts = []
    if field.factor != 1:
        parts.append(f"in {field.factor:.10g} {field.unit}".rstrip())
    elif field.unit:
        parts.append(f"in {field.unit}")
    if field.comment:
        parts.append(field.comment)
    if field.values:
        parts.append(", ".join(f"{raw} {name}" for raw, name in field.values))
    text = "; ".join(parts) or field.name.replace("_", " ")
    return (text[0].upper() + text[1:]).rstrip(".") + "."


def wrapped(prefix: str, text: str, width: int = 108) -> list[str]:
    lines = [prefix]
    for word in text.split():
        if len(lines[-1]) + 1 + len(word) > width:
            lines.append(prefix)
        lines[-1] += " " + word
    return lines


def render_message(message: Layout) -> list[str]:
    names = ", ".join(f"b{i}" if i < message.length else "0" for i in range(8))
    lines = [
        *wrapped("///", message.comment),
        "#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]",
        f"pub struct {message.name} {{",
    ]
    for field in message.fields:
        lines += wrapped("    ///", field_comment(field))
        lines.append(f"    pub {field.name}: {rust_type(field)},")
    lines += [
        "}",
        "",
        f"impl Message for {message.name} {{",
        f"    const ID: u16 = 0x{message.identifier:03x};",
        f"    const LENGTH: usize = {message.length};",
        "",
        "    fn write(&self, out: &mut [u8; 8]) {",
        *(f"        {write_statement(field)}" for field in message.fields),
        f"        *out = [{names}];",
        "    }",
        "",
        "    fn read(payload: &[u8]) -> Option<Self> {",
        f"        let p: &[u8; {message.length}] = payload.try_into().ok()?;",
    ]
    if len(message.fields) == 1 and len(message.fields[0].name) + len(read_expression(message.fields[0])) <= 16:
        only = message.fields[0]
        lines.append(f"        Some(Self {{ {only.name}: {read_expression(only)} }})")
    else:
        lines.append("        Some(Self {")
        lines += [f"            {field.name}: {read_expression(field)}," for field in message.fields]
        lines.append("        })")
    return [*lines, "    }", "}", ""]


def render_values(message: Layout, field: Field) -> list[str]:
    lines = [
        f"/// Values of `{message.name}::{field.name}`.",
        f"pub mod {snake(message.name)}_{field.name} {{",
    ]
    for raw, name in field.values:
        lines.append(f"    /// {name}.")
        lines.append(f"    pub const {snake(name).upper()}: u8 = {raw};")
    return [*lines, "}", ""]


def render(schema: Schema) -> str:
    """The whole file."""
    lines = [
        HEADER,
        "/// CRC-32 of the normalised DBC; `Hello` carries it, a mismatch is refused.",
        f"pub const SCHEMA_HASH: u32 = 0x{schema.hash:08x};",
        "",
        "/// Length of a message's payload, `None` for an identifier that is not in the DBC.",
        "pub const fn length(identifier: u16) -> Option<usize> {",
        "    match identifier {",
        *(f"        {m.name}::ID => Some({m.name}::LENGTH)," for m in schema.messages),
        "        _ => None,",
        "    }",
        "}",
        "",
    ]
    for message in schema.messages:
        lines += render_message(message)
        for field in message.fields:
            if field.values:
                lines += render_values(message, field)
    return "\n".join(lines)
