//! What differs between the two chips that this firmware is built for: the RP2040 of a Pico and the RP2350 of a Pico 2.
//!
//! Exactly one is chosen by a feature of this crate; both modules have the same names in them.

#[cfg(all(feature = "rp2040", feature = "rp235xa"))]
compile_error!(
    "rp2040 and rp235xa exclude each other: build the RP2350 with --no-default-features"
);
#[cfg(not(any(feature = "rp2040", feature = "rp235xa")))]
compile_error!("choose the chip: --features rp2040 or --features rp235xa");

#[cfg(feature = "rp2040")]
mod rp2040;
#[cfg(feature = "rp2040")]
pub use rp2040::*;

#[cfg(all(feature = "rp235xa", not(feature = "rp2040")))]
mod rp2350;
#[cfg(all(feature = "rp235xa", not(feature = "rp2040")))]
pub use rp2350::*;
