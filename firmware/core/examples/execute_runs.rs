//! Drives runs of segments through the real core and says where its reference was: for the comparison with Ruckig in
//! `protocol/tests/test_exactness.py`.
//!
//! Standard input: `duration_us jerk_travel jerk_heading` a line, an empty line between runs. Standard output, every 20 ms
//! and at the end of each run: `run time_us travel heading`, time since the start of the run, travel in 1e-5 m and heading
//! in 1e-6 rad from there, as ReferenceDistance tells them.

#[path = "../tests/rig/mod.rs"]
mod rig;

use std::io::{BufWriter, Read, Write};

use rig::{Piece, Rig};
use rover_protocol::messages as m;
use rover_protocol::Message;

const AT_REST_US: u64 = 60_000;

fn main() -> std::io::Result<()> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let mut out = BufWriter::new(std::io::stdout().lock());
    let mut rig = Rig::armed();
    rig.send(&m::TelemetryRate {
        message: m::ReferenceDistance::ID,
        period: 20,
    });
    rig.run_ms(40);
    for (number, run) in text.split("\n\n").enumerate() {
        let pieces: Vec<Piece> = run.lines().map(piece).collect();
        for (time_us, travel, heading) in execute(&mut rig, &pieces, number as u64) {
            writeln!(out, "{number} {time_us} {travel} {heading}")?;
        }
    }
    out.flush()
}

fn piece(line: &str) -> Piece {
    let mut numbers = line.split_whitespace().map(|word| word.parse::<i32>());
    let mut next = || numbers.next().and_then(Result::ok);
    match (next(), next(), next()) {
        (Some(duration), Some(travel), Some(heading)) => (duration as u32, travel, heading),
        _ => panic!("not three whole numbers: {line}"),
    }
}

/// One run from rest to rest, begun anywhere between two ticks.
fn execute(rig: &mut Rig, pieces: &[Piece], number: u64) -> Vec<(i64, i32, i32)> {
    let origin: m::ReferenceDistance = rig.last().expect("comes every 20 ms");
    let start_us = rig.now_us + 50_000 + number * 137 % 1_000;
    let duration_us: u64 = pieces.iter().map(|piece| u64::from(piece.0)).sum();
    rig.send_start(rig.next_index, start_us);
    for (at, piece) in pieces.iter().enumerate() {
        let flags = u8::from(at == 0) | u8::from(at + 1 == pieces.len()) << 1;
        rig.send_halves(rig.next_index, *piece, flags);
        rig.next_index = rig.next_index.wrapping_add(1);
    }
    let mut samples = vec![];
    while rig.now_us < start_us + duration_us + AT_REST_US {
        rig.frames.clear();
        rig.tick();
        if let Some(reference) = rig.last::<m::ReferenceDistance>() {
            let time_us = rig.now_us as i64 - start_us as i64;
            let travel = reference.travel - origin.travel;
            samples.push((time_us, travel, reference.heading - origin.heading));
        }
        if let Some(fault) = rig.last::<m::Fault>() {
            panic!("run {number}: {fault:?}");
        }
    }
    // For the origin of the next run.
    while rig.last::<m::ReferenceDistance>().is_none() {
        rig.tick();
    }
    samples
}
