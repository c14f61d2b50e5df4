//! Log lines to the companion, in pieces of seven bytes. Lines are constants: nothing is formatted on board.

use heapless::Deque;
use rover_protocol::messages::LogText;

const PIECE: usize = 7;

/// Lines that wait, and how far the first of them has been sent.
#[derive(Debug, Default)]
pub struct Log {
    lines: Deque<&'static str, 4>,
    offset: u8,
}

impl Log {
    /// Queue a line of at most 240 bytes; when four wait already it is dropped.
    pub fn line(&mut self, text: &'static str) {
        let _ = self.lines.push_back(text);
    }

    /// The next piece. The last one of a line holds its zero byte.
    pub fn piece(&mut self) -> Option<LogText> {
        let bytes = self.lines.front()?.as_bytes();
        let rest = bytes.get(usize::from(self.offset)..).unwrap_or(&[]);
        let mut piece = LogText {
            offset: self.offset,
            text: [0; PIECE],
        };
        for (slot, byte) in piece.text.iter_mut().zip(rest) {
            *slot = *byte;
        }
        if rest.len() < PIECE || self.offset > 233 {
            self.lines.pop_front();
            self.offset = 0;
        } else {
            self.offset += PIECE as u8;
        }
        Some(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_whole_and_end_with_a_zero_byte() {
        for text in [
            "",
            "short",
            "exactly",
            "a line that is longer than one piece",
        ] {
            let mut log = Log::default();
            log.line(text);
            let mut bytes = vec![];
            while let Some(piece) = log.piece() {
                assert_eq!(usize::from(piece.offset), bytes.len());
                bytes.extend(piece.text);
            }
            let end = bytes.iter().position(|byte| *byte == 0).unwrap();
            assert_eq!(&bytes[..end], text.as_bytes());
        }
    }
}
