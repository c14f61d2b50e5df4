//! The fast half of the emulated RP2040: processor, interrupt controller, divider, spinlocks, timer and clock in
//! Rust; all other peripherals are Python objects on the same bus. rp2040py's own processor interprets about two
//! million instructions a second, this one a hundred times as many, and most of a firmware's time is instructions.

pub mod alu;
pub mod block_transfer;
#[cfg(not(test))]
pub mod bus;
#[cfg(not(test))]
pub mod clock;
pub mod core;
pub mod divider;
pub mod exceptions;
#[cfg(not(test))]
pub mod memory;
pub mod nvic;
#[cfg(not(test))]
pub mod processor;
pub mod sio;
#[cfg(test)]
mod test_bus;
pub mod thumb;
pub mod timer;

#[cfg(not(test))]
pub use clock::{Alarm, Clock};
#[cfg(not(test))]
pub use processor::Processor;

/// System clock, cycles a microsecond (RP2040 datasheet 2.15: 125 MHz).
pub const CYCLES_PER_US: u64 = 125;
/// Nanoseconds of a cycle: exact at 125 MHz.
pub const CYCLE_NS: u64 = 8;
/// A cycle that never comes.
pub const NEVER: u64 = u64::MAX;
