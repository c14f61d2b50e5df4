//! Who this image is, where whoever flashes it finds it: `rover flash` compares the board's answer with it
//! (companion/src/rover/link/uf2.py).

use rover_core::Identity;

use crate::chip;

/// First 32 bits of the commit, from the build script.
const GIT_HASH: u32 = match u32::from_str_radix(env!("ROVER_GIT_HASH"), 16) {
    Ok(hash) => hash,
    Err(_) => 0,
};

#[repr(C)]
struct Mark {
    magic: [u8; 11],
    board: u8,
    git_hash: [u8; 4],
}

static MARK: Mark = Mark {
    magic: *b"rover image",
    board: chip::BOARD,
    git_hash: GIT_HASH.to_le_bytes(),
};

/// As the handshake tells it.
pub fn identity(reset_cause: u8) -> Identity {
    // SAFETY: a reference. Read as if it could change, so that all of it stays in the image.
    let mark = unsafe { core::ptr::read_volatile(&MARK) };
    Identity {
        board: mark.board,
        git_hash: u32::from_le_bytes(mark.git_hash),
        reset_cause,
    }
}
