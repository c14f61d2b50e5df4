//! The three bit-timing registers from crystal and bit rate (datasheet section 5).

/// The crystal of the MCP2515 board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crystal {
    /// 8 MHz, on most cheap boards.
    Mhz8,
    /// 16 MHz.
    Mhz16,
}

/// Bit rate of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bitrate {
    /// 125 kbit/s.
    Kbit125,
    /// 250 kbit/s.
    Kbit250,
    /// 500 kbit/s.
    Kbit500,
}

/// Contents of CNF1 to CNF3.
///
/// The bit is sampled at 75 % of its length: on a bus of a few metres that leaves as much room as there is for crystals
/// that differ, and the widest resynchronisation jump that phase segment 2 allows (it must be longer than the jump).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming {
    /// Jump width and prescaler.
    pub cnf1: u8,
    /// Propagation segment and phase segment 1.
    pub cnf2: u8,
    /// Phase segment 2.
    pub cnf3: u8,
}

/// Lengths in time quanta; the synchronisation segment is one more.
struct Segments {
    propagation: u8,
    phase1: u8,
    phase2: u8,
    jump: u8,
}

const SIXTEEN_QUANTA: Segments = Segments {
    propagation: 4,
    phase1: 7,
    phase2: 4,
    jump: 3,
};
const EIGHT_QUANTA: Segments = Segments {
    propagation: 2,
    phase1: 3,
    phase2: 2,
    jump: 1,
};

impl BitTiming {
    /// A time quantum is 2 (prescaler + 1) periods of the crystal.
    pub const fn new(crystal: Crystal, bitrate: Bitrate) -> Self {
        match (crystal, bitrate) {
            (Crystal::Mhz8, Bitrate::Kbit500) => Self::of(&EIGHT_QUANTA, 0),
            (Crystal::Mhz8, Bitrate::Kbit250) | (Crystal::Mhz16, Bitrate::Kbit500) => {
                Self::of(&SIXTEEN_QUANTA, 0)
            }
            (Crystal::Mhz8, Bitrate::Kbit125) | (Crystal::Mhz16, Bitrate::Kbit250) => {
                Self::of(&SIXTEEN_QUANTA, 1)
            }
            (Crystal::Mhz16, Bitrate::Kbit125) => Self::of(&SIXTEEN_QUANTA, 3),
        }
    }

    const fn of(segments: &Segments, prescaler: u8) -> Self {
        /// CNF2: phase segment 2 has its own length, in CNF3.
        const BTLMODE: u8 = 0x80;
        Self {
            cnf1: (segments.jump - 1) << 6 | prescaler,
            cnf2: BTLMODE | (segments.phase1 - 1) << 3 | (segments.propagation - 1),
            cnf3: segments.phase2 - 1,
        }
    }
}
