//! Which transmit buffer a frame goes into, and with which priority.
//!
//! The chip sends, of the buffers that wait, the one with the highest priority bits TXP, and among equals the one with
//! the highest number (datasheet section 3.2): so its rank is TXP times 3 plus the number. What waits can't be changed.
//! A new frame needs a rank below all waiting frames with the same or a lower identifier and above all others.

/// Buffers of the chip.
pub const BUFFERS: usize = 3;
/// Four priorities in each.
const RANKS: u8 = 12;

/// A place for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// 0 to 2.
    pub buffer: usize,
    /// TXP, 0 to 3.
    pub priority: u8,
}

/// A frame that waits in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waiting {
    /// 11 bits.
    pub identifier: u16,
    /// TXP.
    pub priority: u8,
}

fn rank(buffer: usize, priority: u8) -> u8 {
    priority * BUFFERS as u8 + buffer as u8
}

/// A place with the right rank; `None` when there is none until something has been sent. Of several the middle one is
/// taken, so that there is room on both sides for what comes next.
pub fn place(identifier: u16, waiting: &[Option<Waiting>; BUFFERS]) -> Option<Place> {
    let mut lowest = 0;
    let mut end = RANKS;
    for (buffer, other) in waiting.iter().enumerate() {
        let Some(other) = other else { continue };
        let theirs = rank(buffer, other.priority);
        if other.identifier <= identifier {
            end = end.min(theirs);
        } else {
            lowest = lowest.max(theirs + 1);
        }
    }
    let free = |rank: &u8| {
        let buffer = usize::from(*rank) % BUFFERS;
        waiting.get(buffer).is_some_and(Option::is_none)
    };
    let count = (lowest..end).filter(free).count();
    let middle = (lowest..end).filter(free).nth(count / 2)?;
    Some(Place {
        buffer: usize::from(middle) % BUFFERS,
        priority: middle / BUFFERS as u8,
    })
}
