//! Partitions of the 2 MiB of flash for updates over the link, as docs/reference/update.md argues them. The firmware of
//! today is not built for them yet; the test of this crate runs the boot loader's crate on them.

#![no_std]

/// Erased as a whole.
pub const SECTOR: u32 = 4096;

/// A stretch of flash, in bytes from its beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    pub start: u32,
    pub length: u32,
}

impl Partition {
    const fn behind(before: Self, length: u32) -> Self {
        Self {
            start: before.start + before.length,
            length,
        }
    }
}

/// Second stage of the boot ROM and the boot loader.
pub const LOADER: Partition = Partition {
    start: 0,
    length: 8 * SECTOR,
};
/// How far a swap is.
pub const STATE: Partition = Partition::behind(LOADER, SECTOR);
/// The image that runs.
pub const ACTIVE: Partition = Partition::behind(STATE, 64 * SECTOR);
/// The image that is to run, and after a swap the one that ran. A sector more than ACTIVE, for swapping.
pub const OTHER: Partition = Partition::behind(ACTIVE, 65 * SECTOR);
/// Of the parameters and the crash record, as today.
pub const PARAMETERS: Partition = Partition {
    start: 2 * 1024 * 1024 - 4 * SECTOR,
    length: 4 * SECTOR,
};

const _: () = assert!(OTHER.start + OTHER.length <= PARAMETERS.start);
/// Bytes in which a swap notes each step. With one, an erase of STATE that is torn could leave the magic byte of a swap
/// and make the byte behind it look erased, by which the crate knows that the steps noted there are void: the swap would
/// begin again over the image that runs. Eight bytes look erased only when all of their bits are.
pub const STATE_WORD: usize = 8;

// A swap and the way back note four steps for each sector, behind magic and validity.
const _: () = assert!((2 + 4 * ACTIVE.length / SECTOR) * STATE_WORD as u32 <= STATE.length);
