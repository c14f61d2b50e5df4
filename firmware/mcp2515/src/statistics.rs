//! What the driver has seen.

use crate::registers::{BUS_OFF, PASSIVE, WARNING};

/// How the chip stands to the bus (datasheet section 6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BusState {
    /// Both error counters are below 96.
    #[default]
    Active,
    /// One is 96 or more.
    Warning,
    /// One is above 127: errors are no longer signalled to others.
    Passive,
    /// The transmit counter went above 255: off the bus until 128 times 11 recessive bits were seen.
    Off,
}

impl BusState {
    pub(crate) fn of(error_flags: u8) -> Self {
        if error_flags & BUS_OFF != 0 {
            Self::Off
        } else if error_flags & PASSIVE != 0 {
            Self::Passive
        } else if error_flags & WARNING != 0 {
            Self::Warning
        } else {
            Self::Active
        }
    }
}

/// Counters wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Data frames taken.
    pub received: u16,
    /// Frames that the bus has acknowledged.
    pub sent: u16,
    /// Times that a frame was lost because both receive buffers were full, for each buffer's flag.
    pub overflows: u16,
    /// Remote frames and extended identifiers: let in by the filters, of no use here.
    pub foreign: u16,
    /// Times that a fault of a frame on the bus was found set: at least one fault each.
    pub message_errors: u16,
    /// Entries into error passive.
    pub passive: u16,
    /// Entries into bus-off.
    pub bus_off: u16,
    /// Frames that waited when the chip went off the bus, and were given up.
    pub abandoned: u16,
    /// Times that the chip was found without its configuration: it had been reset, or is gone.
    pub lost_chip: u16,
    /// Transmit error counter at the last look.
    pub transmit_errors: u8,
    /// Receive error counter at the last look.
    pub receive_errors: u8,
    /// At the last look.
    pub state: BusState,
}
