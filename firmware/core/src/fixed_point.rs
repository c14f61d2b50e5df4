//! Products for a processor that multiplies 32 by 32 bits to 32 and divides only in software: what runs a thousand times a
//! second is scaled by multiplying with a constant, never by dividing 64 bits.

/// The upper half of the 64-bit product, rounded down: `a * b / 2^32`. Four short products instead of a call that costs
/// three times as much.
pub fn upper(a: i32, b: i32) -> i32 {
    let (a_low, a_high) = (a as u32 & 0xffff, a >> 16);
    let (b_low, b_high) = (b as u32 & 0xffff, b >> 16);
    let low = a_low.wrapping_mul(b_low);
    // Neither sum can overflow: 65535 * 32767 + 65535 < 2^31.
    let middle = a_high
        .wrapping_mul(b_low as i32)
        .wrapping_add((low >> 16) as i32);
    let other = (a_low as i32)
        .wrapping_mul(b_high)
        .wrapping_add(middle & 0xffff);
    a_high
        .wrapping_mul(b_high)
        .wrapping_add(middle >> 16)
        .wrapping_add(other >> 16)
}

/// The whole product.
pub fn product(a: i32, b: i32) -> i64 {
    let low = (a as u32).wrapping_mul(b as u32);
    i64::from(upper(a, b)) << 32 | i64::from(low)
}

/// The nearest that fits.
pub fn saturated(value: i64) -> i32 {
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_exact_for_all_signs_and_extremes() {
        let mut values = vec![0, 1, -1, 0xffff, 0x1_0000, -0x1_0000, i32::MAX, i32::MIN];
        let mut state = 1_u32;
        for _ in 0..300 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            values.push(state as i32 >> (state % 31));
        }
        for a in &values {
            for b in &values {
                let exact = i64::from(*a) * i64::from(*b);
                assert_eq!(product(*a, *b), exact, "{a} {b}");
                assert_eq!(i64::from(upper(*a, *b)), exact >> 32, "{a} {b}");
            }
        }
    }
}
