//! Async driver of the CAN controller MCP2515 (datasheet DS20001801), for standard frames, over any
//! [`SpiDevice`](embedded_hal_async::spi::SpiDevice).
//!
//! Its user waits for the INT pin and then calls [`Mcp2515::service`]; between interrupts nothing is asked of the chip but
//! [`Mcp2515::watch`] now and then, which finds a chip that was reset or unplugged and a bus that came back. All waits
//! are bounded, every fault moves a counter of [`Statistics`], and nothing here panics.
//!
//! Frames of one identifier never overtake each other, and of those that wait the one with the lowest identifier goes
//! first ([`transmit_order`]).

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![deny(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable
)]

mod acceptance;
mod bit_timing;
mod change;
mod driver;
mod frame;
mod registers;
mod statistics;
pub mod transmit_order;

pub use acceptance::Acceptance;
pub use bit_timing::{BitTiming, Bitrate, Crystal};
pub use change::Change;
pub use driver::{Configuration, Error, Mcp2515};
pub use frame::Frame;
pub use statistics::{BusState, Statistics};
