"""The model card: one section for each network, so that one can be trained anew without the other."""

from __future__ import annotations

from pathlib import Path

HEAD = """# The two networks

Both are multilayer perceptrons with 256 and 128 hidden units and a softmax (paper section 3.2.1) that tell obstacles,
surface mines, buried mines and background apart. `landmine_ground.onnx` answers where kelvin and metres are known: in
missions, and in pictures with a camera file or with 16 bits and a scale. `landmine_pictures.onnx` answers for all other
pictures, told by `picture_features.onnx` what a network for photographs sees in them. Hash, kind, classes, input length
and the features that a network was trained with are checked when a file is loaded."""


def write_section(card: Path, name: str, text: str) -> None:
    """Puts `text` in the card as the section of the model file `name`; the other sections stay as they are."""
    found = _sections(card.read_text(encoding="utf-8")) if card.is_file() else {}
    found[name] = text.strip()
    parts = [HEAD, *(f"## {title}\n\n{found[title]}" for title in sorted(found))]
    card.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _sections(text: str) -> dict[str, str]:
    """Title and text of every section."""
    parts = text.split("\n## ")[1:]
    return {part.split("\n", 1)[0].strip(): part.split("\n", 1)[1].strip() for part in parts}
