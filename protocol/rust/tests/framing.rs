//! Properties of the framing, over seeded random data.

use rover_protocol::framing::{encode, Decoder, Frame, MAX_FRAME, MAX_PAYLOAD};

/// SplitMix64: enough randomness for tests, no dependency.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Bytes of which many are zero, the hard ones for COBS.
    fn byte(&mut self) -> u8 {
        let bits = self.next();
        if bits & 0x300 == 0 {
            0
        } else {
            bits as u8
        }
    }
}

fn random_frame(random: &mut Random) -> Frame {
    let length = (random.next() % (MAX_PAYLOAD as u64 + 1)) as u8;
    let mut payload = [0; MAX_PAYLOAD];
    for byte in payload.iter_mut().take(length.into()) {
        *byte = random.byte();
    }
    let identifier = u16::from_le_bytes([random.byte(), random.byte()]);
    Frame {
        identifier,
        sequence: random.byte(),
        payload,
        length,
    }
}

fn wire(frame: &Frame) -> Vec<u8> {
    let mut out = [0; MAX_FRAME];
    let length = encode(frame.identifier, frame.sequence, frame.payload(), &mut out);
    out[..length].to_vec()
}

#[test]
fn every_frame_comes_back_and_has_zeros_at_its_ends_only() {
    let mut random = Random(1);
    let mut decoder = Decoder::new();
    for _ in 0..20_000 {
        let frame = random_frame(&mut random);
        let wire = wire(&frame);
        let (last, rest) = wire.split_last().unwrap();
        let (first, rest) = rest.split_first().unwrap();
        assert_eq!((*first, *last), (0, 0));
        assert!(decoder.push(*first).is_none());
        assert!(rest.iter().all(|byte| *byte != 0));
        assert!(rest.iter().all(|byte| decoder.push(*byte).is_none()));
        assert_eq!(decoder.push(0), Some(frame));
    }
    assert_eq!((decoder.checksum_errors, decoder.malformed), (0, 0));
}

#[test]
fn after_any_garbage_the_second_frame_at_the_latest_is_received() {
    let mut random = Random(2);
    for _ in 0..5_000 {
        let mut decoder = Decoder::new();
        for _ in 0..random.next() % 64 {
            decoder.push(random.byte());
        }
        let frame = random_frame(&mut random);
        let twice = [wire(&frame), wire(&frame)].concat();
        let received = twice.into_iter().filter_map(|byte| decoder.push(byte));
        assert_eq!(received.last(), Some(frame));
    }
}

#[test]
fn no_single_bit_error_passes_as_another_frame() {
    let mut random = Random(3);
    for _ in 0..500 {
        let frame = random_frame(&mut random);
        let good = wire(&frame);
        // The zero at the end left alone: damaged, it joins the frame with the next one, which is tested above.
        for bit in 0..8 * (good.len() - 1) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let mut decoder = Decoder::new();
            let received: Vec<Frame> = bad.into_iter().filter_map(|b| decoder.push(b)).collect();
            assert_eq!(received, []);
        }
    }
}

#[test]
fn a_payload_that_is_too_long_is_cut_off() {
    let mut out = [0; MAX_FRAME];
    let length = encode(1, 2, &[7; 20], &mut out);
    let mut decoder = Decoder::new();
    let frame = out[..length]
        .iter()
        .find_map(|byte| decoder.push(*byte))
        .unwrap();
    assert_eq!(frame.payload(), [7; MAX_PAYLOAD]);
}

#[test]
fn a_million_random_bytes_only_move_counters() {
    let mut random = Random(4);
    let mut decoder = Decoder::new();
    let frames = (0..1_000_000)
        .filter_map(|_| decoder.push(random.byte()))
        .count();
    // A 16-bit checksum lets one in 65,536 of the plausible ones through.
    assert!(frames < 20, "{frames} frames out of noise");
    assert!(decoder.checksum_errors > 0 && decoder.malformed > 0);
}
