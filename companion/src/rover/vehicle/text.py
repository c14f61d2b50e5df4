"""Changes values in a TOML file that a person wrote, and leaves comments and everything else as they are."""

from __future__ import annotations

import re


def with_value(text: str, table: str, key: str, literal: str) -> str:
    """The text with `key = literal` in [table]: in the place of the old value, or as the table's last line."""
    lines = text.splitlines()
    header = next((n for n, line in enumerate(lines) if re.match(rf"\s*\[\s*{re.escape(table)}\s*\]", line)), None)
    if header is None:
        return "\n".join(
            [*lines, *([""] if lines and lines[-1].strip() else []), f"[{table}]", f"{key} = {literal}", ""]
        )
    end = next((n for n in range(header + 1, len(lines)) if re.match(r"\s*\[", lines[n])), len(lines))
    for n in range(header + 1, end):
        found = re.match(rf"(\s*{re.escape(key)}\s*=\s*)(\"[^\"]*\"|\[[^\]]*\]|[^#\s]+)(.*)$", lines[n])
        if found:
            lines[n] = f"{found[1]}{literal}{found[3]}"
            return "\n".join(lines) + "\n"
    last = max(n for n in range(header, end) if lines[n].strip() and not lines[n].lstrip().startswith("#"))
    lines.insert(last + 1, f"{key} = {literal}")
    return "\n".join(lines) + "\n"
