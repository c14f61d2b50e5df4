//! A file in place of the board's parameter pages, so that a save outlives the process.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;

use rover_core::storage::{Flash, FlashError, BLOCK, CRASH_PAGE};

/// As on the board.
const PAGE: usize = 4096;

pub struct ParameterFile(File);

impl ParameterFile {
    /// Opens the file; makes one of erased pages if it does not exist or is too short.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        let (length, wanted) = (file.metadata()?.len(), ((CRASH_PAGE + 1) * PAGE) as u64);
        if length < wanted {
            let missing = vec![0xff; (wanted - length) as usize];
            file.write_all_at(&missing, length)?;
        }
        Ok(Self(file))
    }

    fn write(&mut self, page: usize, bytes: &[u8]) -> Result<(), FlashError> {
        let at = (page * PAGE) as u64;
        self.0
            .write_all_at(bytes, at)
            .and_then(|()| self.0.sync_data())
            .map_err(|_| FlashError)
    }
}

impl Flash for ParameterFile {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        self.write(page, &[0xff; PAGE])
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        self.write(page, block)
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        let at = (page * PAGE) as u64;
        self.0.read_exact_at(block, at).map_err(|_| FlashError)
    }
}
