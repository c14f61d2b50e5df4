//! Power lost at every byte of every erase and every write of a save.

use super::*;
use crate::parameters::Parameter;

const PAGE: usize = 4096;

/// Flash that behaves as real cells do: erasing sets bits, programming can only clear them, and after `power` more bytes
/// nothing happens any more, with the byte under way half done.
#[derive(Clone)]
struct Cells {
    pages: [[u8; PAGE]; PAGES],
    power: usize,
    /// What the byte under way is left with.
    torn: u8,
}

impl Cells {
    fn new() -> Self {
        Self {
            pages: [[0xff; PAGE]; PAGES],
            power: usize::MAX,
            torn: 0xff,
        }
    }

    fn put(&mut self, page: usize, at: usize, byte: u8) -> Result<(), FlashError> {
        let torn = self.torn;
        let cell = &mut self.pages[page][at];
        if self.power == 0 {
            // Some bits have changed and some have not.
            *cell = (*cell & torn) | (byte & !torn);
            return Err(FlashError);
        }
        self.power -= 1;
        *cell = byte;
        Ok(())
    }
}

impl Flash for Cells {
    fn erase(&mut self, page: usize) -> Result<(), FlashError> {
        (0..PAGE).try_for_each(|at| self.put(page, at, 0xff))
    }

    fn program(&mut self, page: usize, block: &[u8; BLOCK]) -> Result<(), FlashError> {
        (0..BLOCK).try_for_each(|at| {
            let possible = self.pages[page][at] & block[at];
            self.put(page, at, possible)
        })
    }

    fn read(&mut self, page: usize, block: &mut [u8; BLOCK]) -> Result<(), FlashError> {
        block.copy_from_slice(&self.pages[page][..BLOCK]);
        Ok(())
    }
}

fn with_dead_man(value: i32) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.set(1, value).unwrap();
    parameters
}

fn dead_man(flash: &mut Cells) -> Option<i64> {
    load(flash).map(|parameters| parameters.value(Parameter::DeadManMs))
}

#[test]
fn what_was_saved_is_loaded_and_an_empty_flash_holds_nothing() {
    let mut flash = Cells::new();
    assert_eq!(dead_man(&mut flash), None);
    for value in 100..110 {
        save(&mut flash, &with_dead_man(value)).unwrap();
        assert_eq!(dead_man(&mut flash), Some(i64::from(value)));
    }
}

#[test]
fn power_lost_at_any_byte_of_a_save_leaves_the_old_set_or_the_new_one() {
    // With 1 to 4 earlier saves: both pages, each holding nothing or something older.
    for saves in 1..5 {
        let mut before = Cells::new();
        for i in 0..saves {
            save(&mut before, &with_dead_man(100 + i)).unwrap();
        }
        let (old, new) = (i64::from(100 + saves - 1), 200);
        let (mut olds, mut news) = (0, 0);
        for power in 0..=PAGE + BLOCK {
            for torn in [0x00, 0x0f, 0xa5, 0xff] {
                let mut flash = before.clone();
                (flash.power, flash.torn) = (power, torn);
                let result = save(&mut flash, &with_dead_man(200));
                flash.power = usize::MAX;
                let found = dead_man(&mut flash).expect("never neither");
                assert!(found == old || found == new, "{found} at {power}");
                assert!(result.is_err() || found == new);
                olds += u32::from(found == old);
                news += u32::from(found == new);
                if power % 64 == 0 {
                    save(&mut flash, &with_dead_man(300)).unwrap();
                    assert_eq!(dead_man(&mut flash), Some(300), "a later save works");
                }
            }
        }
        assert!(olds > 0 && news > 0, "{olds} {news}");
    }
}

#[test]
fn the_first_save_that_is_interrupted_leaves_the_defaults_to_be_used() {
    for power in 0..PAGE + IMAGE - 1 {
        let mut flash = Cells::new();
        flash.power = power;
        assert!(save(&mut flash, &with_dead_man(200)).is_err());
        flash.power = usize::MAX;
        assert_eq!(dead_man(&mut flash), None);
    }
}

#[test]
fn the_sequence_number_wraps_without_the_older_set_coming_back() {
    let mut flash = Cells::new();
    flash.pages[0][..BLOCK].copy_from_slice(&image(&with_dead_man(100), u32::MAX));
    save(&mut flash, &with_dead_man(101)).unwrap();
    assert_eq!(dead_man(&mut flash), Some(101));
    save(&mut flash, &with_dead_man(102)).unwrap();
    assert_eq!(dead_man(&mut flash), Some(102));
}

#[test]
fn a_set_of_another_version_brings_what_is_known_and_in_range() {
    let mut block = [0xff; BLOCK];
    block[..4].copy_from_slice(&MAGIC.to_le_bytes());
    block[4..8].copy_from_slice(&9_u32.to_le_bytes());
    block[8..10].copy_from_slice(&3_u16.to_le_bytes());
    for (i, (identifier, value)) in [(999_u16, 5_i32), (1, 400), (2, -1)]
        .into_iter()
        .enumerate()
    {
        let at = HEADER + i * PAIR;
        block[at..at + 2].copy_from_slice(&identifier.to_le_bytes());
        block[at + 2..at + 6].copy_from_slice(&value.to_le_bytes());
    }
    let end = HEADER + 3 * PAIR;
    let sum = crc32(&block[..end]);
    block[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    let mut flash = Cells::new();
    flash.pages[1][..BLOCK].copy_from_slice(&block);
    let parameters = load(&mut flash).unwrap();
    assert_eq!(parameters.value(Parameter::DeadManMs), 400);
    assert_eq!(parameters.value(Parameter::LowVoltageMv), 6_200);
}

#[test]
fn the_checksum_is_that_of_zlib() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}
