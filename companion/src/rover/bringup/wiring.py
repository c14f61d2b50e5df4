"""From which motor turned and which encoder counted to what is crossed, inverted or dead."""

from __future__ import annotations

from dataclasses import dataclass

WHEELS = ("left", "right")
# Counts below which an encoder has said nothing: dither at an edge.
SILENT = 4
# A wheel that hardly turns beside one that does is dragged along.
SHARE = 0.2


@dataclass(frozen=True)
class Pulse:
    """One output of the board was driven forward: what was seen to turn, and what both inputs have counted.

    seen: "left forward", "right back", ..., "nothing".
    """

    output: int
    seen: str
    counts: tuple[int, int]


@dataclass(frozen=True)
class Found:
    """bits: the firmware's parameter `wiring`; faults: what only hands can put right, each a sentence."""

    bits: int
    faults: tuple[str, ...]
    told: tuple[str, ...]


def judge(pulses: tuple[Pulse, Pulse]) -> Found:
    """Of a pulse on the board's left output and one on its right, with nothing put right in software."""
    faults: list[str] = []
    told: list[str] = []
    drives: dict[int, tuple[int, bool]] = {}  # output: the wheel that it drives, and whether forward
    heard: dict[int, list[tuple[int, bool]]] = {0: [], 1: []}  # wheel: inputs that counted, and whether up
    for pulse in pulses:
        inputs = _active(pulse.counts)
        name = WHEELS[pulse.output]
        if pulse.seen == "nothing":
            if inputs:
                faults.append(f"the {name} output: an encoder counts, but no wheel was seen to turn: look again")
            else:
                faults.append(f"the {name} output turns nothing: motor wire, bridge or its supply")
            continue
        word, way = pulse.seen.split()
        wheel, forward = WHEELS.index(word), way == "forward"
        drives[pulse.output] = wheel, forward
        if not inputs:
            faults.append(f"the {word} wheel turns and its encoder counts nothing: supply, or wires A and B")
        elif len(inputs) == 2:
            faults.append(f"the {word} wheel turns and both encoders count: an encoder wire lies on the other one's")
        else:
            heard[wheel].append((inputs[0], (pulse.counts[inputs[0]] > 0) == forward))
    if len(drives) == 2 and drives[0][0] == drives[1][0]:
        faults.append(f"both outputs turn the {WHEELS[drives[0][0]]} wheel: the motors are wired in parallel")
    bits = 0
    crossed = any(output != wheel for output, (wheel, _) in drives.items())
    if crossed:
        bits |= 16
        told.append("the motors are crossed over")
    for wheel, forward in drives.values():
        if not forward:
            bits |= 1 << wheel
            told.append(f"the {WHEELS[wheel]} motor is inverted")
    inputs_of = {wheel: found[0] for wheel, found in heard.items() if found}
    if any(wheel != number for wheel, (number, _) in inputs_of.items()):
        bits |= 32
        told.append("the encoders are crossed over")
    for wheel, (_, up) in inputs_of.items():
        if not up:
            bits |= 4 << wheel
            told.append(f"the {WHEELS[wheel]} encoder is inverted")
    if len(inputs_of) == 2 and inputs_of[0][0] == inputs_of[1][0]:
        faults.append("one input counts for both wheels: the encoders are wired in parallel")
    return Found(bits, tuple(faults), tuple(told) or ("as it should be",))


def _active(counts: tuple[int, int]) -> list[int]:
    """Inputs that have counted."""
    most = max(abs(count) for count in counts)
    return [n for n, count in enumerate(counts) if abs(count) > SILENT and abs(count) >= SHARE * most]
