//! The fast half of the emulated RP2040: processor, interrupt controller, divider, spinlocks, timer and clock in
//! Rust; all other peripherals are Python objects on the same bus. rp2040py's own processor interprets about two
//! million instructions a second, this one a hundred times as many, and most of a firmware's time is instructions.

mod alu;
mod block_transfer;
mod bus;
mod clock;
mod core;
mod divider;
mod exceptions;
mod memory;
mod processor;
mod sio;
mod thumb;
mod timer;

pub use clock::{Alarm, Clock};
pub use processor::Processor;

/// System clock, cycles a microsecond (RP2040 datasheet 2.15: 125 MHz).
pub const CYCLES_PER_US: u64 = 125;
/// Nanoseconds of a cycle: exact at 125 MHz.
pub const CYCLE_NS: u64 = 8;
