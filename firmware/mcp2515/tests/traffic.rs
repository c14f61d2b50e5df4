//! Frames in and out, and their order.

mod chip;

use chip::{block_on, Chip, Clock, OnBus};
use rover_mcp2515::{Acceptance, BitTiming, Bitrate, Configuration, Crystal, Frame, Mcp2515};

fn started() -> (Chip, Mcp2515<Chip>) {
    let chip = Chip::new();
    let configuration = Configuration {
        timing: BitTiming::new(Crystal::Mhz16, Bitrate::Kbit500),
        acceptance: Acceptance::ALL,
    };
    let mut driver = Mcp2515::new(chip.clone(), configuration);
    block_on(driver.start(&mut Clock::default())).unwrap();
    (chip, driver)
}

fn frame(identifier: u16, payload: &[u8]) -> Frame {
    Frame::new(identifier, payload).unwrap()
}

fn service(driver: &mut Mcp2515<Chip>) -> Vec<OnBus> {
    let mut taken = vec![];
    block_on(driver.service(|frame| taken.push((frame.identifier(), frame.payload().to_vec()))))
        .unwrap();
    taken
}

/// xorshift32.
struct Chance(u32);

impl Chance {
    fn below(&mut self, end: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 % end
    }
}

#[test]
fn a_frame_of_each_length_goes_out_and_comes_in_unchanged() {
    let (chip, mut driver) = started();
    let bytes = [0, 0xff, 0x55, 3, 4, 5, 6, 7];
    for length in 0..=8 {
        for identifier in [0, 1, 0x123, 0x7ff] {
            let expected = (identifier, bytes[..length].to_vec());
            assert!(block_on(driver.send(&frame(identifier, &bytes[..length]))).unwrap());
            assert_eq!(chip.speak(), Some(expected.clone()));
            assert!(chip.interrupts());
            assert_eq!(service(&mut driver), []);
            chip.hear(identifier, &bytes[..length]);
            assert!(chip.interrupts());
            assert_eq!(service(&mut driver), [expected]);
            assert!(!chip.interrupts());
        }
    }
    assert_eq!(
        (driver.statistics().sent, driver.statistics().received),
        (36, 36)
    );
    assert_eq!(chip.offences(), Vec::<String>::new());
}

#[test]
fn what_is_no_frame_is_not_made_one() {
    assert_eq!(Frame::new(0x800, &[]), None);
    assert_eq!(Frame::new(1, &[0; 9]), None);
}

#[test]
fn two_frames_wait_for_a_reader_and_a_third_is_counted_as_lost() {
    let (chip, mut driver) = started();
    for number in 0..3 {
        chip.hear(0x40 + number, &[]);
    }
    assert_eq!(service(&mut driver), [(0x40, vec![]), (0x41, vec![])]);
    assert_eq!(driver.statistics().overflows, 1);
    assert!(
        !chip.interrupts(),
        "the overflow does not keep the line low"
    );
    chip.hear(0x50, &[]);
    assert_eq!(service(&mut driver), [(0x50, vec![])]);
    assert_eq!(driver.statistics().overflows, 1);
}

#[test]
fn remote_and_extended_frames_are_counted_and_dropped_and_a_long_length_code_is_eight() {
    let (chip, mut driver) = started();
    let mut image = [0; 13];
    image[1] = 0x10;
    chip.hear_image(0, image);
    assert_eq!(service(&mut driver), []);
    image[1] = 0x08;
    chip.hear_image(0, image);
    assert_eq!(service(&mut driver), []);
    assert_eq!(driver.statistics().foreign, 2);
    image[1] = 0;
    image[4] = 15;
    chip.hear_image(0, image);
    assert_eq!(service(&mut driver), [(0, vec![0; 8])]);
}

#[test]
fn frames_of_one_identifier_keep_their_order() {
    let (chip, mut driver) = started();
    let mut sent = 0_u8;
    let mut heard = vec![];
    let mut chance = Chance(1);
    while heard.len() < 200 {
        while block_on(driver.send(&frame(0x70, &[sent]))).unwrap() {
            sent += 1;
        }
        for _ in 0..=chance.below(3) {
            heard.extend(chip.speak());
        }
        service(&mut driver);
    }
    let order: Vec<u8> = heard.iter().map(|(_, payload)| payload[0]).collect();
    assert_eq!(order, (0..heard.len() as u8).collect::<Vec<_>>());
    assert_eq!(chip.offences(), Vec::<String>::new());
}

#[test]
fn an_urgent_frame_overtakes_those_that_wait() {
    let (chip, mut driver) = started();
    for identifier in [0x080, 0x090, 0x060] {
        assert!(block_on(driver.send(&frame(identifier, &[]))).unwrap());
    }
    let order: Vec<u16> = std::iter::from_fn(|| chip.speak())
        .map(|(identifier, _)| identifier)
        .collect();
    assert_eq!(order, [0x060, 0x080, 0x090]);
}

/// Any mix: of the frames that wait the lowest identifier goes first, among equals the oldest, and every frame gets out.
#[test]
fn whatever_is_sent_goes_out_in_order_of_identifier_and_then_of_age() {
    let (mut tried, mut refused) = (0, 0);
    for seed in 1..200 {
        let mut chance = Chance(seed);
        let (chip, mut driver) = started();
        let mut waiting: Vec<(u16, u8)> = vec![];
        let mut next = 0_u8;
        for _ in 0..200 {
            if chance.below(2) == 0 {
                let identifier = chance.below(4) as u16;
                tried += 1;
                let room = driver.has_room(identifier);
                let taken = block_on(driver.send(&frame(identifier, &[next]))).unwrap();
                assert_eq!(room, taken);
                if taken {
                    waiting.push((identifier, next));
                    next = next.wrapping_add(1);
                } else {
                    assert!(!waiting.is_empty(), "an empty chip takes any frame");
                    refused += u32::from(waiting.len() < 3);
                }
            } else {
                let first = (0..waiting.len()).min_by_key(|i| (waiting[*i].0, *i));
                let expected = first
                    .map(|i| waiting.remove(i))
                    .map(|(identifier, age)| (identifier, vec![age]));
                assert_eq!(chip.speak(), expected);
                service(&mut driver);
            }
        }
        assert_eq!(chip.offences(), Vec::<String>::new());
    }
    // Seldom must a frame wait although a buffer is free, because no priority is left that puts it in its place.
    assert!(20 * refused < tried, "{refused} of {tried}");
}
