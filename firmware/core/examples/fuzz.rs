//! Fuzzes the core's receive and tick: `cargo run --release -p rover-core --example fuzz -- [BYTES] [SEED]`.
//!
//! Build it with CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS=true, so that an overflow counts as a failure too.

#[path = "../tests/fuzz_stream/mod.rs"]
mod fuzz_stream;
#[path = "../tests/rig/mod.rs"]
mod rig;

use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: u64| match arguments.next() {
        Some(text) => text.parse(),
        None => Ok(default),
    };
    let (Ok(bytes), Ok(seed)) = (number(100_000_000), number(1)) else {
        eprintln!("usage: fuzz [BYTES] [SEED], both whole numbers");
        return ExitCode::from(2);
    };
    let start = Instant::now();
    let summary = fuzz_stream::run(bytes, seed);
    println!("{summary:?}");
    println!("{:.1} s", start.elapsed().as_secs_f64());
    ExitCode::SUCCESS
}
