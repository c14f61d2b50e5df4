//! The compiler's calls for 64-bit multiplication and division, answered by `rover_long_arithmetic`.
//!
//! These names replace those of the compiler's own library, which are weak. A division of 32 bits goes on to the chip's
//! hardware divider (feature `intrinsics` of embassy-rp), which may be used from every interrupt level.

use rover_long_arithmetic::{divide, multiply};

#[no_mangle]
extern "C" fn __aeabi_lmul(a: u64, b: u64) -> u64 {
    multiply(a, b)
}

/// Also behind `__aeabi_uldivmod`.
#[no_mangle]
extern "C" fn __udivmoddi4(n: u64, d: u64, remainder: Option<&mut u64>) -> u64 {
    let (quotient, rest) = divide(n, d);
    if let Some(slot) = remainder {
        *slot = rest;
    }
    quotient
}

/// Also behind `__aeabi_ldivmod`. Rounds towards zero; the remainder has the sign of `n`.
#[no_mangle]
extern "C" fn __divmoddi4(n: i64, d: i64, remainder: &mut i64) -> i64 {
    let (quotient, rest) = divide(n.unsigned_abs(), d.unsigned_abs());
    let (quotient, rest) = (quotient as i64, rest as i64);
    *remainder = if n < 0 { rest.wrapping_neg() } else { rest };
    if (n < 0) == (d < 0) {
        quotient
    } else {
        quotient.wrapping_neg()
    }
}
