//! The rover's wire protocol: the messages of `protocol/rover.dbc` and their framing on a serial line.
//!
//! Pure and allocation-free. No input can make it panic: a payload of the wrong length reads as `None`, a damaged
//! frame only moves a counter of [`framing::Decoder`].
//!
//! ```
//! use rover_protocol::{framing, messages, Message};
//!
//! let stop = messages::Stop { reason: 7 };
//! let mut wire = [0; framing::MAX_FRAME];
//! let length = framing::encode_message(&stop, 0, &mut wire);
//!
//! let mut decoder = framing::Decoder::new();
//! let frame = wire[..length].iter().find_map(|byte| decoder.push(*byte)).unwrap();
//! assert_eq!(frame.identifier, messages::Stop::ID);
//! assert_eq!(messages::Stop::read(frame.payload()), Some(stop));
//! ```

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod framing;
pub mod messages;
pub mod rig_tick;

/// A message of the DBC. Fields hold raw integers; the DBC gives their scales.
pub trait Message: Sized {
    /// CAN identifier, 11 bits.
    const ID: u16;
    /// Bytes of payload, at most 8.
    const LENGTH: usize;

    /// Lay the fields out in the first `LENGTH` bytes of `out`; the rest becomes zero.
    fn write(&self, out: &mut [u8; 8]);

    /// `None` unless `payload` is exactly `LENGTH` bytes long. Every payload of that length is a message.
    fn read(payload: &[u8]) -> Option<Self>;
}
