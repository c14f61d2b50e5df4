"""Render protocol/rust/src/rig_tick.rs. The text is what rustfmt would make of it."""

from __future__ import annotations

from tools.generate.tick_records import TickField, TickRecord, TickRecords

HEADER = """//! One millisecond between a simulated rig and its firmware, as bytes on a pair of pipes.
//!
//! Written by `python -m tools.generate`: change protocol/rig_tick.toml, not this file.
"""


def read_expression(field: TickField) -> str:
    places = [f"b[{place}]" for place in range(field.start, field.start + field.size)]
    return places[0] if field.type == "u8" else f"{field.type}::from_le_bytes([{', '.join(places)}])"


def read_lines(field: TickField) -> list[str]:
    line = f"            {field.name}: {read_expression(field)},"
    if len(line) <= 100:
        return [line]
    places = ", ".join(f"b[{place}]" for place in range(field.start, field.start + field.size))
    return [
        f"            {field.name}: {field.type}::from_le_bytes([",
        f"                {places},",
        "            ]),",
    ]


def write_line(field: TickField) -> str:
    if field.type == "u8":
        return f"        out[{field.start}] = self.{field.name};"
    place = f"{field.start}..{field.start + field.size}"
    return f"        out[{place}].copy_from_slice(&self.{field.name}.to_le_bytes());"


def render_record(record: TickRecord) -> list[str]:
    lines = [
        f"/// {record.comment}",
        "#[derive(Clone, Copy, Debug, PartialEq, Eq)]",
        f"pub struct {record.name} {{",
    ]
    for field in record.named:
        lines += [f"    /// {field.comment}", f"    pub {field.name}: {field.type},"]
    return [
        *lines,
        "}",
        "",
        f"impl {record.name} {{",
        "    /// Bytes on the pipe.",
        f"    pub const SIZE: usize = {record.size};",
        "",
        "    /// The bytes on the pipe.",
        "    pub fn write(&self) -> [u8; Self::SIZE] {",
        "        let mut out = [0; Self::SIZE];",
        *(write_line(field) for field in record.named),
        "        out",
        "    }",
        "",
        "    /// From the bytes on the pipe; every one of them is a record.",
        "    pub fn read(b: &[u8; Self::SIZE]) -> Self {",
        "        Self {",
        *(line for field in record.named for line in read_lines(field)),
        "        }",
        "    }",
        "}",
    ]


def render(records: TickRecords) -> str:
    """The whole file."""
    lines = [HEADER]
    for constant in records.constants:
        shown = constant.value if constant.type != "u64" else f"0x{constant.value:x}"
        lines += [f"/// {constant.comment}", f"pub const {constant.name}: {constant.type} = {shown};"]
    for record in records.records:
        lines += ["", *render_record(record)]
    return "\n".join(lines) + "\n"
