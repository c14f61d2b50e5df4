//! Errors on the bus and of the chip: each is counted, and the driver goes on.

mod chip;

use chip::{block_on, Chip, Clock, Wiring};
use rover_mcp2515::{
    Acceptance, BitTiming, Bitrate, BusState, Configuration, Crystal, Error, Frame, Mcp2515,
};

fn started() -> (Chip, Mcp2515<Chip>) {
    let chip = Chip::new();
    let configuration = Configuration {
        timing: BitTiming::new(Crystal::Mhz16, Bitrate::Kbit250),
        acceptance: Acceptance::ALL,
    };
    let mut driver = Mcp2515::new(chip.clone(), configuration);
    block_on(driver.start(&mut Clock::default())).unwrap();
    (chip, driver)
}

fn service(driver: &mut Mcp2515<Chip>) {
    block_on(driver.service(|_| {})).unwrap();
}

fn send(driver: &mut Mcp2515<Chip>, identifier: u16) -> bool {
    block_on(driver.send(&Frame::new(identifier, &[1]).unwrap())).unwrap()
}

#[test]
fn error_counters_and_error_passive_are_reported_each_time_it_is_entered() {
    let (chip, mut driver) = started();
    chip.errors(100, 3);
    service(&mut driver);
    assert_eq!(driver.statistics().state, BusState::Warning);
    chip.errors(130, 3);
    service(&mut driver);
    assert_eq!(driver.statistics().state, BusState::Passive);
    assert_eq!(
        (
            driver.statistics().transmit_errors,
            driver.statistics().receive_errors
        ),
        (130, 3)
    );
    assert!(
        !chip.interrupts(),
        "a state that lasts does not keep the line low"
    );
    chip.errors(0, 0);
    block_on(driver.watch()).unwrap();
    assert_eq!(driver.statistics().state, BusState::Active);
    chip.errors(0, 128);
    service(&mut driver);
    assert_eq!(driver.statistics().passive, 2);
}

#[test]
fn bus_off_gives_up_what_waits_and_sending_goes_on_after_the_recovery() {
    let (chip, mut driver) = started();
    for identifier in [0x60, 0x60, 0x70] {
        assert!(send(&mut driver, identifier));
    }
    chip.errors(256, 0);
    service(&mut driver);
    assert_eq!(driver.statistics().state, BusState::Off);
    assert_eq!(
        (driver.statistics().bus_off, driver.statistics().abandoned),
        (1, 3)
    );
    assert!(
        !driver.has_room(0) && !send(&mut driver, 0x60),
        "nothing is queued for a bus that is gone"
    );
    block_on(driver.watch()).unwrap();
    assert_eq!(driver.statistics().bus_off, 1);

    chip.errors(0, 0);
    assert_eq!(chip.speak(), None, "nothing old is sent");
    block_on(driver.watch()).unwrap();
    assert_eq!(driver.statistics().state, BusState::Active);
    assert!(send(&mut driver, 0x61));
    assert_eq!(chip.speak(), Some((0x61, vec![1])));
    service(&mut driver);
    assert_eq!(driver.statistics().sent, 1);
    assert_eq!(chip.offences(), Vec::<String>::new());
}

#[test]
fn a_frame_that_was_sent_just_before_bus_off_frees_no_buffer_that_is_used_again() {
    let (chip, mut driver) = started();
    assert!(send(&mut driver, 0x60));
    assert!(chip.speak().is_some());
    chip.errors(256, 0);
    block_on(driver.watch()).unwrap();
    chip.errors(0, 0);
    block_on(driver.watch()).unwrap();
    for identifier in [0x60, 0x61, 0x62] {
        assert!(send(&mut driver, identifier));
        service(&mut driver);
    }
    assert!(!send(&mut driver, 0x63), "all three still wait");
    assert_eq!(chip.offences(), Vec::<String>::new());
}

#[test]
fn faults_of_frames_on_the_bus_are_counted_without_an_interrupt_of_their_own() {
    let (chip, mut driver) = started();
    chip.message_error();
    assert!(!chip.interrupts());
    chip.hear(1, &[]);
    service(&mut driver);
    assert_eq!(
        (
            driver.statistics().message_errors,
            driver.statistics().received
        ),
        (1, 1)
    );
}

#[test]
fn faults_of_frames_are_seen_on_a_bus_without_a_single_good_one() {
    let (chip, mut driver) = started();
    for seen in 1..=3 {
        chip.message_error();
        block_on(driver.watch()).unwrap();
        block_on(driver.watch()).unwrap();
        assert_eq!(driver.statistics().message_errors, seen);
    }
}

#[test]
fn a_chip_that_was_reset_or_unplugged_is_found_and_can_be_started_again() {
    for fault in 0..3 {
        let (chip, mut driver) = started();
        assert!(send(&mut driver, 0x60));
        match fault {
            0 => chip.0.borrow_mut().reset(),
            1 => chip.0.borrow_mut().wiring = Wiring::Reads(0x00),
            _ => chip.0.borrow_mut().wiring = Wiring::Reads(0xff),
        }
        assert_eq!(block_on(driver.watch()), Err(Error::Lost));
        assert_eq!(driver.statistics().lost_chip, 1);
        chip.0.borrow_mut().wiring = Wiring::Sound;
        block_on(driver.start(&mut Clock::default())).unwrap();
        assert!(send(&mut driver, 0x61) && send(&mut driver, 0x61) && send(&mut driver, 0x61));
        assert_eq!(chip.speak(), Some((0x61, vec![1])));
    }
}

#[test]
fn a_line_that_always_reads_high_ends_a_service_after_a_bounded_number_of_transfers() {
    let (chip, mut driver) = started();
    chip.0.borrow_mut().wiring = Wiring::Reads(0xff);
    let mut frames = 0;
    let result = block_on(driver.service(|_| frames += 1));
    assert_eq!(result, Err(Error::Lost));
    assert_eq!(frames, 0);
}

/// Registers that change at random under the driver: it never panics, never waits without end, and a restart mends all.
#[test]
fn no_register_content_stops_the_driver() {
    let (chip, mut driver) = started();
    let mut state = 0x2545_f491_u32;
    for _ in 0..20_000 {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        let [address, value, identifier, choice] = state.to_le_bytes();
        chip.set(usize::from(address & 0x7f), value);
        let before = chip.0.borrow().transactions;
        let _ = match choice % 4 {
            0 => {
                block_on(driver.send(&Frame::new(u16::from(identifier), &[]).unwrap())).map(|_| ())
            }
            1 => block_on(driver.watch()),
            2 => block_on(driver.start(&mut Clock::default())),
            _ => block_on(driver.service(|_| {})).map(|_| ()),
        };
        assert!(chip.0.borrow().transactions - before < 120);
    }
    block_on(driver.start(&mut Clock::default())).unwrap();
    assert!(send(&mut driver, 1));
    assert_eq!(chip.speak(), Some((1, vec![1])));
}
