//! What survives a crash: a journal in memory that no start clears, and what the next start makes of it.
//!
//! The watchdog resets without a word, so the journal is kept up to date all the time: the task that runs, the last
//! events, the uptime. Shortly before the watchdog bites an alarm of its own notes where the program is; when interrupts
//! are off at that time the program counter stays unknown.

use core::cell::UnsafeCell;
use core::future::Future;
use core::mem::MaybeUninit;
use core::pin::Pin;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::{Context, Poll};

use embassy_rp::interrupt::InterruptExt;
use embassy_time::{Duration, Instant};
use rover_core::crash::{CrashEvent, CrashRecord, EVENTS};
use rover_protocol::messages::{crash_cause_cause as cause, hello_build_reset_cause as reset};

use crate::chip::{TIMER, WARNING};

const ALARM: usize = 2;
const MAGIC: u32 = 0x4a52_5652; // "RVRJ"
/// So long before the watchdog bites it is noted where the program is.
const WARNED: Duration = Duration::from_millis(5);
/// Twice the period of looking after the tasks.
const LOOKED_AFTER_MS: u32 = 40;
/// Words below the stack's top that are painted to see how much of it was used: 16 KiB.
const PAINTED: usize = 4_096;
const PAINT: u32 = 0x5354_4b21;

/// As in the message CrashCause.
pub use rover_protocol::messages::crash_cause_task as task;

#[repr(C)]
struct Journal {
    magic: AtomicU32,
    cause: AtomicU32,
    task: AtomicU32,
    detail: AtomicU32,
    program_counter: AtomicU32,
    /// When the watchdog was about to bite, or the program could not go on; 0: neither was noticed.
    warned_ms: AtomicU32,
    /// When it was looked last whether every task lives, and which did not.
    checked_ms: AtomicU32,
    missing: AtomicU32,
    /// Events so far; the ring holds the last of them.
    noted: AtomicU32,
    times_ms: [AtomicU32; EVENTS],
    /// Kind, and detail above it.
    whats: [AtomicU32; EVENTS],
}

/// Not initialised, so what was there before the reset is there after it.
struct Kept(UnsafeCell<MaybeUninit<Journal>>);

// SAFETY: atomics only.
unsafe impl Sync for Kept {}

#[link_section = ".uninit.JOURNAL"]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

fn journal() -> &'static Journal {
    // SAFETY: any bit pattern is an AtomicU32; after power-on they hold noise, which MAGIC and the reset cause tell.
    unsafe { &*KEPT.0.get().cast::<Journal>() }
}

fn get(word: &AtomicU32) -> u32 {
    word.load(Ordering::Relaxed)
}

fn set(word: &AtomicU32, value: u32) {
    word.store(value, Ordering::Relaxed);
}

/// The crash before this start, if it was one, and a fresh journal. First of all, while little of the stack is in use.
pub fn begin(reset_cause: u8) -> Option<CrashRecord> {
    let journal = journal();
    let valid = get(&journal.magic) == MAGIC;
    let record = (valid && reset_cause == reset::WATCHDOG).then(|| record(journal));
    for word in [
        &journal.cause,
        &journal.task,
        &journal.detail,
        &journal.program_counter,
        &journal.warned_ms,
        &journal.checked_ms,
        &journal.missing,
        &journal.noted,
    ] {
        set(word, 0);
    }
    set(&journal.magic, MAGIC);
    paint_stack();
    // SAFETY: its handler needs nothing but the journal.
    unsafe { WARNING.enable() };
    TIMER.inte().modify(|w| w.set_alarm(ALARM, true));
    record
}

fn record(journal: &Journal) -> CrashRecord {
    let noted = get(&journal.noted) as usize;
    let count = noted.min(EVENTS);
    let mut events = [CrashEvent::default(); EVENTS];
    for (slot, number) in events.iter_mut().zip(noted - count..noted) {
        let at = number % EVENTS;
        if let (Some(time), Some(what)) = (journal.times_ms.get(at), journal.whats.get(at)) {
            let [kind, _, low, high] = get(what).to_le_bytes();
            *slot = CrashEvent {
                time_ms: get(time),
                kind,
                detail: u16::from_le_bytes([low, high]),
            };
        }
    }
    let cause = match get(&journal.cause) as u8 {
        cause::NONE => cause::WATCHDOG,
        known => known,
    };
    let (warned_ms, checked_ms) = (get(&journal.warned_ms), get(&journal.checked_ms));
    // While somebody still looks after the tasks, the one that it misses has stopped; otherwise the one that runs
    // keeps the processor.
    let looked_after = warned_ms != 0 && warned_ms <= checked_ms.saturating_add(LOOKED_AFTER_MS);
    let task = match cause == cause::WATCHDOG && looked_after {
        true => get(&journal.missing),
        false => get(&journal.task),
    };
    CrashRecord {
        cause,
        task: task as u8,
        detail: get(&journal.detail) as u16,
        program_counter: get(&journal.program_counter),
        uptime_ms: warned_ms.max(checked_ms),
        stack_bytes: stack_used(),
        count: count as u8,
        events,
    }
}

/// From the control loop alone.
pub fn note(event: &CrashEvent) {
    let journal = journal();
    let noted = get(&journal.noted);
    let at = noted as usize % EVENTS;
    if let (Some(time), Some(what)) = (journal.times_ms.get(at), journal.whats.get(at)) {
        let [low, high] = event.detail.to_le_bytes();
        set(time, event.time_ms);
        set(what, u32::from_le_bytes([event.kind, 0, low, high]));
    }
    set(&journal.noted, noted.wrapping_add(1));
}

/// The watchdog was fed; it bites when it is not again within `timeout`.
pub fn expect_feeding(timeout: Duration) {
    let journal = journal();
    set(&journal.program_counter, 0);
    set(&journal.warned_ms, 0);
    let warning = Instant::now() + timeout - WARNED;
    TIMER.alarm(ALARM).write_value(warning.as_micros() as u32);
}

/// It was looked whether every task lives; `missing` is the first that has not shown it, or IDLE.
pub fn checked(missing: u8) {
    let journal = journal();
    set(&journal.missing, u32::from(missing));
    set(&journal.checked_ms, now_ms());
}

/// For a program that cannot go on. The watchdog's reset follows.
pub fn die(cause: u8, detail: u16, program_counter: u32) {
    let journal = journal();
    set(&journal.cause, u32::from(cause));
    set(&journal.detail, u32::from(detail));
    set(&journal.program_counter, program_counter);
    set(&journal.warned_ms, now_ms());
}

fn now_ms() -> u32 {
    Instant::now().as_millis() as u32
}

/// The watchdog is about to bite.
#[no_mangle]
extern "C" fn rover_warning(program_counter: u32) {
    TIMER.intr().write(|w| w.set_alarm(ALARM, true));
    let journal = journal();
    set(&journal.program_counter, program_counter);
    set(&journal.warned_ms, now_ms());
}

/// The alarm's interrupt: hands on the program counter that the processor has stacked behind r0-r3, r12 and lr.
macro_rules! warning_handler {
    ($name:literal) => {
        core::arch::global_asm!(
            concat!(".section .text.", $name, ",\"ax\",%progbits"),
            ".balign 4",
            concat!(".global ", $name),
            concat!(".type ", $name, ",%function"),
            ".thumb_func",
            concat!($name, ":"),
            "mrs r0, msp",
            "ldr r0, [r0, #24]",
            "ldr r1, 1f",
            "bx r1",
            ".balign 4",
            "1: .word rover_warning",
        );
    };
}
#[cfg(feature = "rp2040")]
warning_handler!("TIMER_IRQ_2");
#[cfg(not(feature = "rp2040"))]
warning_handler!("TIMER0_IRQ_2");

/// Tells whose turn it is while the future is polled.
pub async fn within<F: Future>(task: u8, future: F) -> F::Output {
    Within { task, future }.await
}

struct Within<F> {
    task: u8,
    future: F,
}

impl<F: Future> Future for Within<F> {
    type Output = F::Output;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<F::Output> {
        let current = &journal().task;
        // What is interrupted here goes on afterwards.
        let interrupted = get(current);
        set(current, u32::from(self.task));
        // SAFETY: the future is not moved out of what is pinned.
        let future = unsafe { self.map_unchecked_mut(|within| &mut within.future) };
        let polled = future.poll(context);
        set(current, interrupted);
        polled
    }
}

extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The lowest word that is painted, and the stack's top.
fn painted() -> (*mut u32, *mut u32) {
    let top = (&raw const _stack_start).cast_mut();
    let end = (&raw const _stack_end).cast_mut();
    (top.wrapping_sub(PAINTED).max(end), top)
}

fn paint_stack() {
    let (mut at, _) = painted();
    // Room for what this very call uses.
    let until = (cortex_m::register::msp::read() as *mut u32).wrapping_sub(64);
    while at < until {
        // SAFETY: memory below the stack's pointer, which nobody uses.
        unsafe { at.write_volatile(PAINT) };
        at = at.wrapping_add(1);
    }
}

/// Most that the stack has held since it was painted, in bytes, as far as it was.
fn stack_used() -> u16 {
    let (mut at, top) = painted();
    // SAFETY: memory of the stack.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    (top as usize)
        .saturating_sub(at as usize)
        .min(usize::from(u16::MAX)) as u16
}
