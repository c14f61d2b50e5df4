//! Instructions (datasheet section 12), register addresses (section 11) and the bits that the driver uses.

/// Back to the state after power-on; then 128 periods of the crystal must pass (section 8.1).
pub const RESET: u8 = 0xc0;
pub const READ: u8 = 0x03;
pub const WRITE: u8 = 0x02;
pub const BIT_MODIFY: u8 = 0x05;
/// Reads from RXB0SIDH on and clears RX0IF when CS goes high; bit 2 selects RXB1.
pub const READ_RECEIVE_BUFFER: u8 = 0x90;
/// With one bit for each of the three transmit buffers.
pub const REQUEST_TO_SEND: u8 = 0x80;

pub const CANCTRL: u8 = 0x0f;
/// Transmit error counter; the receive error counter is next to it.
pub const TEC: u8 = 0x1c;
/// First of CNF3, CNF2, CNF1, CANINTE, CANINTF, EFLG.
pub const CNF3: u8 = 0x28;
/// EFLG is next to it.
pub const CANINTF: u8 = 0x2c;
pub const EFLG: u8 = 0x2d;
pub const TXB0CTRL: u8 = 0x30;
/// From one transmit buffer to the next.
pub const TRANSMIT_BUFFER_STEP: u8 = 0x10;
pub const RXB0CTRL: u8 = 0x60;
pub const RXB1CTRL: u8 = 0x70;
/// SIDH of each filter.
pub const FILTERS: [u8; 6] = [0x00, 0x04, 0x08, 0x10, 0x14, 0x18];
/// SIDH of each mask.
pub const MASKS: [u8; 2] = [0x20, 0x24];

/// CANCTRL after a reset: configuration mode, clock output on.
pub const CANCTRL_AFTER_RESET: u8 = 0x87;
/// CANCTRL: normal mode, retransmission on (OSM = 0), clock output off.
pub const NORMAL_MODE: u8 = 0x00;
/// OPMOD in CANSTAT.
pub const MODE_MASK: u8 = 0xe0;

/// RXB0CTRL: a frame that finds RXB0 full goes to RXB1.
pub const ROLLOVER: u8 = 0x04;

/// CANINTF and CANINTE.
pub const RECEIVED: [u8; 2] = [0x01, 0x02];
pub const SENT: [u8; 3] = [0x04, 0x08, 0x10];
pub const ERROR: u8 = 0x20;
pub const MESSAGE_ERROR: u8 = 0x80;
/// MERRF stays off: without another node on the bus it would come with each retransmission, some 4000 times a second.
pub const ENABLED: u8 = 0x3f;

/// EFLG.
pub const OVERFLOW: [u8; 2] = [0x40, 0x80];
pub const BUS_OFF: u8 = 0x20;
pub const PASSIVE: u8 = 0x18;
pub const WARNING: u8 = 0x07;

/// TXBnCTRL: the buffer waits for the bus.
pub const TRANSMIT_REQUEST: u8 = 0x08;

/// SIDL of a received frame: remote request, or extended identifier.
pub const NOT_A_DATA_FRAME: u8 = 0x18;
