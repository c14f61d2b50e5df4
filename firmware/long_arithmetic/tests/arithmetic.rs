//! Against the desktop's own arithmetic.

use rover_long_arithmetic::{divide, multiply};

/// Around every power of two, and around the borders of the digits.
fn interesting() -> Vec<u64> {
    let mut values = vec![
        0,
        3,
        10,
        1_000,
        1_000_000,
        6_000_000,
        u64::MAX / 3,
        0xffff_0000_ffff,
    ];
    for bit in 0..64 {
        let power = 1_u64 << bit;
        values.extend([power - 1, power, power + 1, !power]);
    }
    values
}

fn check(n: u64, d: u64) {
    assert_eq!(multiply(n, d), n.wrapping_mul(d), "{n:#x} * {d:#x}");
    if d != 0 {
        assert_eq!(divide(n, d), (n / d, n % d), "{n:#x} / {d:#x}");
    }
}

#[test]
fn borders() {
    let values = interesting();
    for n in &values {
        for d in &values {
            check(*n, *d);
        }
    }
}

#[test]
fn two_million_pairs_of_random_lengths() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for _ in 0..2_000_000 {
        let lengths = next();
        let (n, d) = (next() >> (lengths & 63), next() >> (lengths >> 6 & 63));
        check(n, d);
        // A remainder of 0 and one that is the largest.
        let product = n.wrapping_mul(d);
        check(product, d);
        check(product.wrapping_sub(1), d);
    }
}

#[test]
fn a_division_by_zero_ends() {
    assert_eq!(divide(5, 0), (u64::MAX, 0));
}
