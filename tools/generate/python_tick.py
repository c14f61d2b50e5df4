"""Render protocol/python/rover_protocol/rig_tick.py, which must also compile on MicroPython."""

from __future__ import annotations

from tools.generate.tick_records import TickRecord, TickRecords

HEADER = '''"""One millisecond between a simulated rig and its firmware, as bytes on a pair of pipes.

Written by `python -m tools.generate`: change protocol/rig_tick.toml, not this file.
"""

import struct
'''


def render_record(record: TickRecord) -> list[str]:
    lines = ["", "", f"class {record.name}:", f'    """{record.comment}', ""]
    lines += [f"    {field.name}: {field.comment}" for field in record.named]
    lines += ['    """', "", f"    SIZE = {record.size}", f'    FORMAT = "{record.format}"', ""]
    lines.append("    def __init__(")
    lines.append("        self,")
    lines += [f"        {field.name}: int = {field.default}," for field in record.named]
    lines.append("    ) -> None:")
    lines += [f"        self.{field.name} = {field.name}" for field in record.named]
    lines += [
        "",
        "    def pack(self) -> bytes:",
        f'        """The {record.size} bytes."""',
        "        return struct.pack(",
        "            self.FORMAT,",
        *(f"            self.{field.name}," for field in record.named),
        "        )",
        "",
        "    @classmethod",
        f'    def unpack(cls, data: bytes) -> "{record.name}":',
        f'        """From {record.size} bytes. Raises struct.error when there are more or fewer."""',
        "        return cls(*struct.unpack(cls.FORMAT, data))",
    ]
    return lines


def render(records: TickRecords) -> str:
    """The whole file."""
    lines = [HEADER]
    for constant in records.constants:
        lines += [f"# {constant.comment}", f"{constant.name} = {constant.value}"]
    for record in records.records:
        lines += render_record(record)
    return "\n".join(lines) + "\n"
