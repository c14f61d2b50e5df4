//! The ASCII protocol of serial CAN adapters, as python-can's `slcan` interface and Linux' `slcand` speak it: one command
//! a line, ended by a carriage return; frames both ways are lines too.

use crate::can_frame::CanFrame;

pub const END: u8 = b'\r';
/// Answer to a command that was not understood or not possible.
pub const REFUSED: u8 = 0x07;
/// Longest line: an extended frame of eight bytes.
pub const LONGEST: usize = 26;

/// What the host asks of the adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// An empty line, which some hosts send to clear the adapter's buffer.
    Nothing,
    Open,
    Close,
    /// Number of a standard bit rate; 6 is 500 kbit/s.
    Bitrate(u8),
    Transmit(CanFrame),
    /// A frame that no node here listens to: extended or remote.
    Foreign,
    Version,
    SerialNumber,
    Flags,
    /// Accepted without effect: time stamps, filters.
    Setting,
    Unknown,
}

/// A line without its carriage return.
pub fn parse(line: &[u8]) -> Command {
    match line {
        [] => Command::Nothing,
        b"O" => Command::Open,
        b"C" => Command::Close,
        b"V" => Command::Version,
        b"N" => Command::SerialNumber,
        b"F" => Command::Flags,
        [b'S', digit @ b'0'..=b'8'] => Command::Bitrate(digit - b'0'),
        [b'Z' | b'M' | b'm', ..] => Command::Setting,
        [b't', rest @ ..] => frame(rest).map_or(Command::Unknown, Command::Transmit),
        [b'T' | b'R', rest @ ..] if rest.len() >= 9 => Command::Foreign,
        [b'r', rest @ ..] if rest.len() >= 4 => Command::Foreign,
        _ => Command::Unknown,
    }
}

/// Identifier in three digits, length in one, two for each byte; a time stamp must not follow.
fn frame(text: &[u8]) -> Option<CanFrame> {
    let identifier = hexadecimal(text.get(..3)?)?;
    let length = hexadecimal(text.get(3..4)?)?;
    let digits = text.get(4..)?;
    if identifier > 0x7ff || length > 8 || digits.len() != usize::from(length) * 2 {
        return None;
    }
    let mut payload = [0; 8];
    for (byte, pair) in payload.iter_mut().zip(digits.chunks(2)) {
        *byte = hexadecimal(pair)? as u8;
    }
    let payload = payload.get(..usize::from(length))?;
    Some(CanFrame::new(identifier, payload))
}

fn hexadecimal(digits: &[u8]) -> Option<u16> {
    digits.iter().try_fold(0, |value: u16, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(value << 4 | digit as u16)
    })
}

/// The line that tells the host of a frame.
pub fn line(frame: &CanFrame) -> String {
    let data: String = frame
        .payload()
        .iter()
        .map(|byte| format!("{byte:02X}"))
        .collect();
    format!("t{:03X}{}{data}\r", frame.identifier, frame.payload().len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_the_same_in_both_directions() {
        for payload in [&[][..], &[0, 0xff], &[1, 2, 3, 4, 5, 6, 7, 0xa8]] {
            let frame = CanFrame::new(0x7f0, payload);
            let text = line(&frame);
            assert!(text.len() <= LONGEST);
            let text = text.trim_end().as_bytes();
            assert_eq!(parse(text), Command::Transmit(frame));
        }
        let stop = CanFrame::new(0x010, &[7]);
        assert_eq!(line(&stop), "t010107\r");
        assert_eq!(parse(b"t010107"), Command::Transmit(stop));
        assert_eq!(parse(b"t01010a"), parse(b"t01010A"));
    }

    #[test]
    fn what_is_no_command_is_unknown_and_never_a_frame() {
        for bad in [
            &b"t0101"[..],
            b"t01010",
            b"t01010700",
            b"t801107",
            b"t0109000000000000000000",
            b"t01x107",
            b"t",
            b"S9",
            b"S",
            b"Q",
            b"\xff\x00",
            b"T1",
        ] {
            assert_eq!(parse(bad), Command::Unknown, "{bad:?}");
        }
        assert_eq!(parse(b"T000000101FF"), Command::Foreign);
        assert_eq!(parse(b"r0108"), Command::Foreign);
    }
}
