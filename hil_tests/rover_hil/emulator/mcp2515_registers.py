"""Registers of the MCP2515 (DS20001801, table 11-1): addresses, bits, and what a reset and each mode allow."""

from __future__ import annotations

from rover_hil.emulator.can_bus import Frame

FILTERS = (0x00, 0x04, 0x08, 0x10, 0x14, 0x18)
MASKS = (0x20, 0x24)
CANSTAT, CANCTRL = 0x0E, 0x0F
TEC, REC = 0x1C, 0x1D
CNF3, CNF2, CNF1, CANINTE, CANINTF, EFLG = 0x28, 0x29, 0x2A, 0x2B, 0x2C, 0x2D
TX_CONTROL = (0x30, 0x40, 0x50)
RX_CONTROL = (0x60, 0x70)

NORMAL, SLEEP, LOOPBACK, LISTEN, CONFIGURATION = 0, 1, 2, 3, 4
"""Modes: bits 7 to 5 of CANCTRL and CANSTAT."""
ABORT_ALL, ONE_SHOT = 1 << 4, 1 << 3

RX0_FLAG, RX1_FLAG, TX0_FLAG, ERROR_FLAG, WAKE_FLAG, MESSAGE_ERROR_FLAG = 1, 2, 4, 1 << 5, 1 << 6, 1 << 7
WARNING, RX_WARNING, TX_WARNING, RX_PASSIVE, TX_PASSIVE, BUS_OFF, RX0_OVERFLOW, RX1_OVERFLOW = (
    1 << bit for bit in range(8)
)
ABORTED, LOST_ARBITRATION, TX_ERROR, TX_REQUEST = 1 << 6, 1 << 5, 1 << 4, 1 << 3
ROLL_OVER = 1 << 2

# Figure 12-7: elsewhere the mask of BIT MODIFY is taken as 0xff.
BIT_MODIFIABLE = {0x0C, 0x0D, CANCTRL, CNF3, CNF2, CNF1, CANINTE, CANINTF, EFLG, *TX_CONTROL, *RX_CONTROL}
READ_ONLY = {CANSTAT, TEC, REC}
WRITABLE_BITS = {EFLG: 0xC0, 0x30: 0x0B, 0x40: 0x0B, 0x50: 0x0B, 0x60: 0x64, 0x70: 0x60, 0x0D: 0x07, 0x0C: 0x3F}
CONFIGURATION_ONLY = {
    *(base + byte for base in (*FILTERS, *MASKS) for byte in range(4)), CNF3, CNF2, CNF1, 0x0D,
}  # fmt: skip


def reset_values() -> bytearray:
    """All 128 after a reset: configuration mode, clock output on."""
    registers = bytearray(128)
    registers[CANCTRL], registers[CANSTAT] = 0x87, 0x80
    return registers


def canonical(address: int) -> int:
    """CANSTAT and CANCTRL are seen in every row."""
    low = address & 0x0F
    return low if low in (CANSTAT, CANCTRL) else address & 0x7F


def identifier_bytes(frame: Frame) -> bytes:
    """SIDH, SIDL, EID8, EID0 and DLC of a received frame (registers 4-4 to 4-8)."""
    standard = frame.identifier >> 18 if frame.extended else frame.identifier
    low = frame.identifier & 0x3FFFF if frame.extended else 0
    sidl = (standard & 7) << 5 | frame.extended << 3 | low >> 16
    if not frame.extended:
        sidl |= frame.remote << 4
    dlc = frame.length | (frame.remote << 6 if frame.extended else 0)
    return bytes((standard >> 3, sidl, low >> 8 & 0xFF, low & 0xFF, dlc))


def frame_of(buffer: bytes | bytearray) -> Frame:
    """The frame in a transmit buffer of 13 bytes (registers 3-3 to 3-8)."""
    sidh, sidl, eid8, eid0, dlc = buffer[:5]
    extended = bool(sidl >> 3 & 1)
    identifier = sidh << 3 | sidl >> 5
    if extended:
        identifier = identifier << 18 | (sidl & 3) << 16 | eid8 << 8 | eid0
    remote, length = bool(dlc >> 6 & 1), min(8, dlc & 0x0F)
    return Frame(identifier, b"" if remote else bytes(buffer[5 : 5 + length]), extended, remote, length)


def matches(frame: Frame, mask: bytes, acceptance: bytes) -> bool:
    """Section 4.5: the bits of the identifier that the mask selects, those of the first two data bytes for a standard
    frame beside the extended identifier; a filter takes only its own kind of frame."""
    if bool(acceptance[1] >> 3 & 1) != frame.extended:
        return False
    head = bytearray(identifier_bytes(frame)[:4])
    if not frame.extended:
        head[2:4] = (frame.data + b"\0\0")[:2]
    masks = (mask[0], mask[1] & 0xE3, mask[2], mask[3])
    if not frame.extended:
        masks = (mask[0], mask[1] & 0xE0, mask[2], mask[3])
    return all((value ^ wanted) & bits == 0 for value, wanted, bits in zip(head, acceptance, masks, strict=True))
