//! The power is cut at every operation of flash of an update, of its trial and of the way back: there is always a whole
//! image to start, and never one that was not signed.

use std::cell::RefCell;
use std::rc::Rc;

use ed25519_dalek::{Signer, SigningKey};
use embassy_boot::{
    BlockingFirmwareUpdater, BootLoader, BootLoaderConfig, FirmwareUpdaterConfig, State,
};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rover_update::{Partition, SECTOR, STATE_WORD};
use sha2::{Digest, Sha512};

/// Smaller than on the board, so that every cut can be tried: the crate counts sectors and not bytes.
const SECTORS: u32 = 6;
const STATE: Partition = Partition {
    start: 0,
    length: SECTOR,
};
const ACTIVE: Partition = Partition {
    start: SECTOR,
    length: SECTORS * SECTOR,
};
const OTHER: Partition = Partition {
    start: (1 + SECTORS) * SECTOR,
    length: (SECTORS + 1) * SECTOR,
};
const PARAMETERS: Partition = Partition {
    start: (2 + 2 * SECTORS) * SECTOR,
    length: SECTOR,
};
const ALL: usize = ((3 + 2 * SECTORS) * SECTOR) as usize;
const PAGE: usize = 256;

/// What a cut leaves of the operation that it meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cut {
    /// Nothing of it was done.
    Before,
    /// Of a program the first half; of an erase all of it, without a word.
    Midway,
    /// As Midway, and of an erase some of the bits.
    Torn(u32),
    /// As Midway, and of an erase all bytes but the first: with steps noted in bytes that one would end without an image.
    AllButOne,
}

struct Chip {
    cells: Vec<u8>,
    /// Operations until the power goes; None: never.
    left: Option<u32>,
    cut: Cut,
    operations: u32,
}

/// Some bits are erased and others not yet.
fn tear(cells: &mut [u8], seed: u32) {
    let mut state = seed;
    for cell in cells {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *cell |= (state >> 24) as u8;
    }
}

#[derive(Clone)]
struct Part {
    chip: Rc<RefCell<Chip>>,
    place: Partition,
}

#[derive(Debug)]
struct PowerLost;

impl NorFlashError for PowerLost {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Part {
    type Error = PowerLost;
}

impl ReadNorFlash for Part {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerLost> {
        let from = (self.place.start + offset) as usize;
        bytes.copy_from_slice(&self.chip.borrow().cells[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.place.length as usize
    }
}

impl Part {
    /// Carry out an operation on cells, or what the cut leaves of it.
    fn operate(
        &mut self,
        from: u32,
        length: usize,
        work: impl Fn(&mut [u8], Cut),
    ) -> Result<(), PowerLost> {
        let mut chip = self.chip.borrow_mut();
        chip.operations += 1;
        let whole = match &mut chip.left {
            Some(0) => return Err(PowerLost),
            Some(left) => {
                *left -= 1;
                *left > 0
            }
            None => true,
        };
        let cut = chip.cut;
        let at = (self.place.start + from) as usize;
        let cells = &mut chip.cells[at..at + length];
        if whole {
            work(cells, Cut::Before);
            return Ok(());
        }
        if cut != Cut::Before {
            work(cells, cut);
        }
        Err(PowerLost)
    }
}

impl NorFlash for Part {
    const WRITE_SIZE: usize = STATE_WORD;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerLost> {
        for sector in (from..to).step_by(SECTOR as usize) {
            self.operate(sector, SECTOR as usize, |cells, cut| match cut {
                Cut::Torn(seed) => tear(cells, seed),
                Cut::AllButOne => cells.iter_mut().skip(1).for_each(|cell| *cell = 0xff),
                _ => cells.fill(0xff),
            })?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerLost> {
        for (number, page) in bytes.chunks(PAGE).enumerate() {
            self.operate(offset + (number * PAGE) as u32, page.len(), |cells, cut| {
                let length = match cut {
                    Cut::Before => page.len(),
                    Cut::Midway | Cut::Torn(_) | Cut::AllButOne => page.len() / 2,
                };
                for (cell, byte) in cells.iter_mut().zip(page).take(length) {
                    assert_eq!(*cell & *byte, *byte, "only erasing sets a bit");
                    *cell = *byte;
                }
            })?;
        }
        Ok(())
    }
}

struct Board {
    chip: Rc<RefCell<Chip>>,
}

/// Bytes that are those of this image and of no other.
fn image(number: u8) -> Vec<u8> {
    let length = (ACTIVE.length - 700) as usize;
    (0..length)
        .map(|at| (at as u8).wrapping_mul(31) ^ number ^ (at >> 8) as u8)
        .collect()
}

impl Board {
    /// With image 1 in it, and parameters.
    fn new() -> Self {
        let mut cells = vec![0xff; ALL];
        let place = |partition: Partition| partition.start as usize;
        let old = image(1);
        cells[place(ACTIVE)..place(ACTIVE) + old.len()].copy_from_slice(&old);
        cells[place(PARAMETERS)..].fill(0x5a);
        let chip = Chip {
            cells,
            left: None,
            cut: Cut::Before,
            operations: 0,
        };
        Self {
            chip: Rc::new(RefCell::new(chip)),
        }
    }

    fn part(&self, place: Partition) -> Part {
        Part {
            chip: self.chip.clone(),
            place,
        }
    }

    /// A start: what the boot loader does, None when the power goes meanwhile.
    fn start(&self) -> Option<State> {
        let mut loader = BootLoader::new(BootLoaderConfig {
            active: self.part(ACTIVE),
            dfu: self.part(OTHER),
            state: self.part(STATE),
        });
        loader.prepare_boot(&mut [0; PAGE]).ok()
    }

    fn updater<R>(
        &self,
        work: impl FnOnce(&mut BlockingFirmwareUpdater<'_, Part, Part>) -> R,
    ) -> R {
        let mut aligned = [0; STATE_WORD];
        let config = FirmwareUpdaterConfig {
            dfu: self.part(OTHER),
            state: self.part(STATE),
        };
        work(&mut BlockingFirmwareUpdater::new(config, &mut aligned))
    }

    /// Image 2 comes over the link and is marked for the next start; false when the power went.
    fn receive(&self, signed_by: &SigningKey, trusted: &SigningKey) -> bool {
        let new = image(2);
        let signature = signed_by.sign(&Sha512::digest(&new)).to_bytes();
        let key = trusted.verifying_key().to_bytes();
        self.updater(|updater| {
            let pieces = new.chunks(64).enumerate();
            let written = pieces
                .map(|(number, piece)| updater.write_firmware(number * 64, piece))
                .all(|result| result.is_ok());
            written
                && updater
                    .verify_and_mark_updated(&key, &signature, new.len() as u32)
                    .is_ok()
        })
    }

    fn cut_after(&self, operations: u32, cut: Cut) {
        let mut chip = self.chip.borrow_mut();
        (chip.left, chip.cut) = (Some(operations), cut);
    }

    fn power_on(&self) {
        self.chip.borrow_mut().left = None;
    }

    /// The number of the image that is whole where the program is started.
    fn running(&self) -> Option<u8> {
        let chip = self.chip.borrow();
        let from = ACTIVE.start as usize;
        (1..=2).find(|number| {
            let image = image(*number);
            chip.cells[from..from + image.len()] == image
        })
    }

    fn check(&self, what: &str) -> u8 {
        let chip = self.chip.borrow();
        assert!(
            chip.cells[PARAMETERS.start as usize..]
                .iter()
                .all(|byte| *byte == 0x5a),
            "parameters, {what}"
        );
        drop(chip);
        self.running()
            .unwrap_or_else(|| panic!("no whole image, {what}"))
    }
}

fn keys() -> (SigningKey, SigningKey) {
    (
        SigningKey::from_bytes(&[7; 32]),
        SigningKey::from_bytes(&[8; 32]),
    )
}

/// An update whose image is well, or hangs; returns the operations of flash that it took.
fn update(board: &Board, well: bool) -> u32 {
    let (ours, _) = keys();
    // Each step goes on whatever became of the one before, as after a loss of power nobody knows.
    if board.receive(&ours, &ours) {
        board.start();
        if well && board.running() == Some(2) {
            let _ = board.updater(|updater| updater.mark_booted());
        }
        board.start();
    }
    board.chip.borrow().operations
}

#[test]
fn an_image_that_is_well_stays_and_one_that_does_not_say_so_goes() {
    let board = Board::new();
    update(&board, true);
    assert_eq!(board.check("well"), 2);
    let board = Board::new();
    update(&board, false);
    assert_eq!(board.check("hangs"), 1);
    assert_eq!(board.start(), Some(State::Revert), "and is not tried again");
    assert_eq!(board.check("hangs"), 1);
}

#[test]
fn an_image_of_a_stranger_is_never_started() {
    let (ours, strangers) = keys();
    let board = Board::new();
    assert!(!board.receive(&strangers, &ours));
    assert_eq!(board.start(), Some(State::Boot));
    assert_eq!(board.check("a stranger's"), 1);
}

#[test]
fn at_every_cut_there_is_a_whole_image_and_the_next_update_goes_through() {
    for well in [true, false] {
        let all = update(&Board::new(), well);
        assert!(all > 200, "{all}");
        for cut in [
            Cut::Before,
            Cut::Midway,
            Cut::Torn(1),
            Cut::Torn(2),
            Cut::AllButOne,
        ] {
            for operations in 0..all {
                let what = format!("cut {cut:?} at {operations} of {all}, image well: {well}");
                let board = Board::new();
                board.cut_after(operations, cut);
                update(&board, well);
                board.power_on();
                // Two starts: the second finds a trial that was not confirmed.
                board.start();
                board.check(&what);
                board.start();
                let running = board.check(&what);
                assert!(well || running == 1, "an image that hangs, {what}");
                update(&board, true);
                assert_eq!(board.check(&what), 2, "{what}");
            }
        }
    }
}
