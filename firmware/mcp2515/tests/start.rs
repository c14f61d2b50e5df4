//! Reset, bit timing, acceptance, and a chip that is not there.

mod chip;

use chip::{block_on, Chip, Clock, Wiring};
use rover_mcp2515::{Acceptance, BitTiming, Bitrate, Configuration, Crystal, Error, Mcp2515};

const FILTERED: Acceptance = Acceptance {
    masks: [0x780, 0x7ff],
    filters: [0x000, 0x100, 0x7f0, 0x7f1, 0x7f2, 0x7f3],
};

fn configuration(acceptance: Acceptance) -> Configuration {
    Configuration {
        timing: BitTiming::new(Crystal::Mhz8, Bitrate::Kbit500),
        acceptance,
    }
}

/// Bit rate in bit/s, sample point in percent and the rules of section 5.3, worked out from the registers.
fn decode(timing: BitTiming, crystal_hz: u32) -> (u32, u32) {
    let quantum_periods = 2 * (u32::from(timing.cnf1 & 0x3f) + 1);
    let jump = u32::from(timing.cnf1 >> 6) + 1;
    let propagation = u32::from(timing.cnf2 & 7) + 1;
    let phase1 = u32::from(timing.cnf2 >> 3 & 7) + 1;
    let phase2 = u32::from(timing.cnf3 & 7) + 1;
    assert_eq!(timing.cnf2 >> 6, 0b10, "own phase segment 2, one sample");
    assert!(propagation + phase1 >= phase2);
    assert!(phase2 > jump && phase2 >= 2);
    let quanta = 1 + propagation + phase1 + phase2;
    assert_eq!(
        crystal_hz % (quantum_periods * quanta),
        0,
        "the rate is exact"
    );
    (
        crystal_hz / (quantum_periods * quanta),
        100 * (1 + propagation + phase1) / quanta,
    )
}

#[test]
fn each_crystal_gives_each_rate_exactly() {
    let crystals = [(Crystal::Mhz8, 8_000_000), (Crystal::Mhz16, 16_000_000)];
    let rates = [
        (Bitrate::Kbit125, 125_000),
        (Bitrate::Kbit250, 250_000),
        (Bitrate::Kbit500, 500_000),
    ];
    for (crystal, hertz) in crystals {
        for (bitrate, expected) in rates {
            assert_eq!(
                decode(BitTiming::new(crystal, bitrate), hertz),
                (expected, 75)
            );
        }
    }
}

#[test]
fn a_started_chip_is_in_normal_mode_with_its_configuration() {
    let chip = Chip::new();
    let mut driver = Mcp2515::new(chip.clone(), configuration(FILTERED));
    let mut clock = Clock::default();
    block_on(driver.start(&mut clock)).unwrap();
    assert_eq!(chip.mode(), 0);
    let timing = BitTiming::new(Crystal::Mhz8, Bitrate::Kbit500);
    assert_eq!(
        [chip.get(0x2a), chip.get(0x29), chip.get(0x28)],
        [timing.cnf1, timing.cnf2, timing.cnf3]
    );
    assert_eq!(chip.get(0x0f) & 0x08, 0, "one-shot mode is off");
    assert_eq!(chip.offences(), Vec::<String>::new());
    assert!(clock.waited_us <= 20_000);
}

#[test]
fn only_what_the_filters_name_comes_in() {
    let chip = Chip::new();
    let mut driver = Mcp2515::new(chip.clone(), configuration(FILTERED));
    block_on(driver.start(&mut Clock::default())).unwrap();
    for identifier in 0..0x800 {
        chip.hear(identifier, &[1]);
        let mut taken = vec![];
        block_on(driver.service(|frame| taken.push(frame.identifier()))).unwrap();
        let expected = if FILTERED.accepts(identifier) {
            vec![identifier]
        } else {
            vec![]
        };
        assert_eq!(taken, expected);
    }
    assert!(FILTERED.accepts(0x7f) && !FILTERED.accepts(0x80) && FILTERED.accepts(0x7f0));
}

#[test]
fn a_crystal_that_swings_up_slowly_is_waited_for() {
    let chip = Chip::new();
    chip.0.borrow_mut().oscillator_starts_after = 5;
    let mut driver = Mcp2515::new(chip.clone(), configuration(Acceptance::ALL));
    assert_eq!(block_on(driver.start(&mut Clock::default())), Ok(()));
}

#[test]
fn a_chip_that_is_not_there_is_found_out_within_20_ms() {
    for level in [0x00, 0xff] {
        let chip = Chip::new();
        chip.0.borrow_mut().wiring = Wiring::Reads(level);
        let mut driver = Mcp2515::new(chip.clone(), configuration(Acceptance::ALL));
        let mut clock = Clock::default();
        assert_eq!(block_on(driver.start(&mut clock)), Err(Error::Absent));
        assert!(clock.waited_us <= 20_000);
        assert!(chip.0.borrow().transactions <= 20);
    }
}

#[test]
fn a_bus_that_is_held_low_is_told_from_a_chip_that_is_not_there() {
    let chip = Chip::new();
    chip.0.borrow_mut().wiring = Wiring::BusHeldLow;
    let mut driver = Mcp2515::new(chip.clone(), configuration(Acceptance::ALL));
    let mut clock = Clock::default();
    assert_eq!(block_on(driver.start(&mut clock)), Err(Error::BusStuck));
    assert!(clock.waited_us <= 20_000);
}
