//! Either wire behind one face.

use std::os::fd::AsFd;

use rover_core::Core;

use crate::can_adapter::CanAdapter;
use crate::line::Line;
use crate::options::{Options, WireKind};
use crate::serial::Serial;

pub enum Wire {
    Serial(Serial),
    Can(CanAdapter),
}

impl Wire {
    /// Takes the line of `options` over.
    pub fn open(options: &Options) -> Self {
        let line = Line::open(options.serial);
        match options.wire {
            WireKind::Serial => Self::Serial(Serial::new(line, options.baud)),
            WireKind::Can => Self::Can(CanAdapter::new(line, options.baud)),
        }
    }

    /// Bytes that went out to the host since the start.
    pub fn bytes_sent(&self) -> u64 {
        match self {
            Self::Serial(serial) => serial.bytes_sent(),
            Self::Can(adapter) => adapter.bytes_sent(),
        }
    }

    /// One line about what went over it, for the log.
    pub fn statistics(&self, now_us: u64) -> String {
        match self {
            Self::Serial(serial) => format!("serial: {} bytes sent", serial.bytes_sent()),
            Self::Can(adapter) => {
                let counters = adapter.counters();
                let load = counters.bits * 200 / now_us.max(1);
                let (frames, refused) = (counters.frames, counters.refused);
                format!("can: {frames} frames, {load} % of the bus, {refused} frames refused")
            }
        }
    }

    /// Feed the core what has come; see [`Line::receive`].
    pub fn receive(&mut self, core: &mut Core, due: u64, now_us: u64, ticks: &impl AsFd) -> bool {
        match self {
            Self::Serial(serial) => serial.receive(core, due, now_us, ticks),
            Self::Can(adapter) => adapter.receive(core, due, now_us, ticks),
        }
    }

    /// Send what the core has to say until `now_us`.
    pub fn transmit(&mut self, core: &mut Core, now_us: u64) {
        match self {
            Self::Serial(serial) => serial.transmit(core, now_us),
            Self::Can(adapter) => adapter.transmit(core, now_us),
        }
    }
}
