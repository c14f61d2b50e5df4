//! 64-bit multiplication and division from 32-bit ones, for the Cortex-M0+ of the RP2040.
//!
//! That core multiplies 32 × 32 bits into 32 and the chip divides 32 by 32 bits in hardware; the compiler's own routines
//! know of neither and cost three times as much. The control loop divides 64-bit numbers, mostly by small ones, dozens
//! of times each millisecond. Nothing here uses a 64-bit multiplication or division, so it can stand in for them.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

/// The lower 64 bits of the product.
pub fn multiply(a: u64, b: u64) -> u64 {
    let (a_high, a_low) = halves(a);
    let (b_high, b_low) = halves(b);
    let cross = a_high
        .wrapping_mul(b_low)
        .wrapping_add(a_low.wrapping_mul(b_high));
    let (high, low) = halves(multiply_halves(a_low, b_low));
    join(high.wrapping_add(cross), low)
}

/// The whole product.
fn multiply_halves(a: u32, b: u32) -> u64 {
    let (a_high, a_low) = (a >> 16, a & 0xffff);
    let (b_high, b_low) = (b >> 16, b & 0xffff);
    let (middle, carry) = (a_high * b_low).overflowing_add(a_low * b_high);
    let (low, low_carry) = (a_low * b_low).overflowing_add(middle << 16);
    let high = a_high * b_high + (u32::from(carry) << 16) + (middle >> 16) + u32::from(low_carry);
    join(high, low)
}

/// Quotient and remainder. Division by zero gives the largest quotient and remainder 0: Rust has checked before.
pub fn divide(n: u64, d: u64) -> (u64, u64) {
    let (n_high, n_low) = halves(n);
    let (d_high, d_low) = halves(d);
    if d_high != 0 {
        return if n < d { (0, n) } else { divide_by_long(n, d) };
    }
    if d_low == 0 {
        return (u64::MAX, 0);
    }
    if n_high == 0 {
        return (u64::from(n_low / d_low), u64::from(n_low % d_low));
    }
    // Schoolbook with digits of 32 bits: the first is one division, the second a 64 by 32 one without overflow.
    let (first, rest) = if n_high < d_low {
        (0, n_high)
    } else {
        (n_high / d_low, n_high % d_low)
    };
    let (second, remainder) = if d_low >> 16 == 0 {
        divide_by_short(rest, n_low, d_low)
    } else {
        divide_by_word(rest, n_low, d_low)
    };
    (join(first, second), u64::from(remainder))
}

/// `high < d < 2^16`: two digits of 16 bits, each of which fits in one 32-bit division.
fn divide_by_short(high: u32, low: u32, d: u32) -> (u32, u32) {
    let upper = high << 16 | low >> 16;
    let (first, rest) = (upper / d, upper % d);
    let lower = rest << 16 | low & 0xffff;
    ((first << 16) | (lower / d), lower % d)
}

/// `high < d`, `d >= 2^16`: two digits of 16 bits, each estimated from the upper half of the divisor (Knuth, algorithm D).
fn divide_by_word(high: u32, low: u32, d: u32) -> (u32, u32) {
    // With the top bit of the divisor set an estimate is at most 2 too large.
    let shift = d.leading_zeros();
    let d = d << shift;
    let (mut high, mut low) = (high, low);
    if shift > 0 {
        high = high << shift | low >> (32 - shift);
        low <<= shift;
    }
    let (first, rest) = digit(high, low >> 16, d);
    let (second, rest) = digit(rest, low & 0xffff, d);
    (first << 16 | second, rest >> shift)
}

/// One digit of 16 bits: `(high · 2^16 + next) / d` and its remainder, for `high < d` and a divisor with its top bit set.
fn digit(high: u32, next: u32, d: u32) -> (u32, u32) {
    let (d_high, d_low) = (d >> 16, d & 0xffff);
    let mut estimate = (high / d_high).min(0xffff);
    let mut rest = high - estimate * d_high;
    let mut short = estimate * d_low;
    // rest · 2^16 + next must not be less than what the lower half takes away.
    while rest >> 16 == 0 && short > (rest << 16 | next) {
        estimate -= 1;
        rest += d_high;
        short -= d_low;
    }
    (estimate, (rest << 16 | next).wrapping_sub(short))
}

/// `n >= d >= 2^32`: the quotient is less than 2^32. Divide by the upper 32 bits of the divisor, which gives it or one
/// more (Hacker's Delight, section 9-5).
fn divide_by_long(n: u64, d: u64) -> (u64, u64) {
    let shift = d.leading_zeros();
    let (upper, _) = halves(d << shift);
    let (high, low) = halves(n >> 1);
    let (estimate, _) = divide_by_word(high, low, upper);
    let estimate = (estimate >> (31 - shift)).saturating_sub(1);
    let rest = n.wrapping_sub(multiply(u64::from(estimate), d));
    if rest >= d {
        (u64::from(estimate) + 1, rest - d)
    } else {
        (u64::from(estimate), rest)
    }
}

fn halves(value: u64) -> (u32, u32) {
    ((value >> 32) as u32, value as u32)
}

fn join(high: u32, low: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}
