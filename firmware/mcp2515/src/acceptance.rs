//! Which identifiers the chip lets in (datasheet section 4.5).

/// Two masks and six filters. A frame is taken when it agrees with a filter in every bit that the filter's mask has set:
/// filters 0 and 1 with mask 0 for RXB0 (and RXB1 when that is full), filters 2 to 5 with mask 1 for RXB1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acceptance {
    /// 11 bits each.
    pub masks: [u16; 2],
    /// 11 bits each.
    pub filters: [u16; 6],
}

impl Acceptance {
    /// Everything that is on the bus.
    pub const ALL: Self = Self {
        masks: [0; 2],
        filters: [0; 6],
    };

    /// Whether a data frame with that identifier is let in.
    pub const fn accepts(&self, identifier: u16) -> bool {
        let [first, second] = self.masks;
        let [a, b, c, d, e, f] = self.filters;
        agrees(identifier, a, first)
            || agrees(identifier, b, first)
            || agrees(identifier, c, second)
            || agrees(identifier, d, second)
            || agrees(identifier, e, second)
            || agrees(identifier, f, second)
    }
}

const fn agrees(identifier: u16, filter: u16, mask: u16) -> bool {
    (identifier ^ filter) & mask == 0
}
