//! Short programs, instruction by instruction. Longer ones are in hil_tests/tests/test_emulator_processor.py.

use super::super::test_bus::{booted, TestBus, CODE, STACK};
use super::*;

/// The core after these instructions, and the cycles of the last one.
fn after(program: &[u16], prepare: impl FnOnce(&mut Core)) -> (Core, u64, TestBus) {
    let mut bus = TestBus::default();
    for (index, op) in program.iter().enumerate() {
        bus.half(CODE + 2 * index as u32, *op);
    }
    let mut core = booted(&mut bus);
    prepare(&mut core);
    let mut cycles = 0;
    for _ in program {
        cycles = core.step(&mut bus).unwrap();
    }
    (core, cycles, bus)
}

#[test]
fn immediates_move_add_and_compare() {
    // movs r0, #200; adds r0, #100; subs r1, r0, #7; cmp r0, r1
    let (core, cycles, _) = after(&[0x20C8, 0x3064, 0x1FC1, 0x4288], |_| {});
    assert_eq!((core.r[0], core.r[1], cycles), (300, 293, 1));
    assert!(core.flags.c && !core.flags.z);
}

#[test]
fn loads_and_stores_reach_memory_in_two_cycles() {
    // str r0, [sp, #4]; ldr r1, [sp, #4]; ldrb r2, [r3, #1]
    let (core, cycles, _) = after(&[0x9001, 0x9901, 0x785A], |core| {
        core.r[0] = 0x1234_5678;
        core.r[SP] = STACK - 16;
        core.r[3] = STACK - 12;
    });
    assert_eq!((core.r[1], core.r[2], cycles), (0x1234_5678, 0x56, 2));
}

#[test]
fn push_and_pop_are_each_others_inverse() {
    // push {r0, r1, lr}; pop {r2, r3}; a stack word is left
    let (core, cycles, bus) = after(&[0xB503, 0xBC0C], |core| {
        core.r[0] = 1;
        core.r[1] = 2;
        core.r[LR] = 0x101;
    });
    assert_eq!(
        (core.r[2], core.r[3], core.r[SP], cycles),
        (1, 2, STACK - 4, 3)
    );
    assert_eq!(bus.read_word(STACK - 4), 0x101);
}

#[test]
fn branches_take_two_cycles_when_taken() {
    // movs r0, #0; beq +4
    let (core, cycles, _) = after(&[0x2000, 0xD000], |_| {});
    assert_eq!((core.r[PC], cycles), (CODE + 6, 2));
    let (core, cycles, _) = after(&[0x2001, 0xD000], |_| {});
    assert_eq!((core.r[PC], cycles), (CODE + 4, 1));
}

#[test]
fn an_undefined_instruction_and_a_crooked_address_are_hard_faults() {
    for (op, r0) in [(0xDE00, 0), (0x6800, STACK + 2 - 8)] {
        let mut bus = TestBus::default();
        bus.half(CODE, op);
        let mut core = booted(&mut bus);
        core.r[0] = r0;
        assert_eq!(core.step(&mut bus), Err(Fault::Hard), "{op:#06x}");
    }
}
