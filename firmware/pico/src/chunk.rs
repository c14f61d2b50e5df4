//! What a wire hands over at once.

/// Bytes that came in together, and when the last of them did.
pub struct Chunk {
    pub time_us: u64,
    bytes: [u8; Self::SIZE],
    length: usize,
}

impl Chunk {
    /// As many as arrive in one tick of the control loop.
    const SIZE: usize = 24;

    pub fn new(time_us: u64) -> Self {
        Self {
            time_us,
            bytes: [0; Self::SIZE],
            length: 0,
        }
    }

    pub fn has_room(&self) -> bool {
        self.length < Self::SIZE
    }

    /// Beyond [`Chunk::has_room`] nothing happens.
    pub fn push(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(self.length) {
            *slot = byte;
            self.length += 1;
        }
    }

    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&self.bytes)
    }
}
