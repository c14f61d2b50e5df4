//! What the CAN controller's driver has counted, on its way to the companion: every fault moves a counter there too.
//!
//! Faulty frames on the bus go into `LinkStatistics.checksum_errors`, lost frames are the faults ReceiveOverflow and
//! TransmitOverflow with the controller's state and error counters as detail, and what somebody has to look after is a
//! line in the log.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant};
use rover_core::Core;
use rover_mcp2515::Statistics;
use rover_protocol::messages::fault_code;

/// Each line at most this often; the counters know of all.
const LINE_PERIOD: Duration = Duration::from_secs(5);

/// Faulty frames, two faults and three lines.
const MOST_NEWS: usize = 6;

enum News {
    Line(&'static str),
    Fault { code: u8, times: u16, detail: u32 },
    Errors(u16),
}

/// To the control loop. When it is full, what is left over is told later.
static NEWS: Channel<CriticalSectionRawMutex, News, 8> = Channel::new();

/// Hand over to the core what there is.
pub fn deliver(core: &mut Core) {
    while let Ok(news) = NEWS.try_receive() {
        match news {
            News::Line(text) => core.log_line(text),
            News::Fault {
                code,
                times,
                detail,
            } => core.note_fault(code, times, detail),
            News::Errors(count) => core.note_bus_errors(count),
        }
    }
}

const ABSENT: &str = "CAN: no MCP2515 answers at start, so the CAN bus is not used";
static IS_ABSENT: AtomicBool = AtomicBool::new(false);

/// No chip is fitted: said when the companion comes, as that is later than the start.
pub fn note_absent() {
    IS_ABSENT.store(true, Ordering::Relaxed);
}

/// A companion has greeted on one of the serial wires.
pub fn greet(core: &mut Core) {
    if IS_ABSENT.load(Ordering::Relaxed) {
        core.log_line(ABSENT);
    }
}

/// A line that is said again and again at most once in [`LINE_PERIOD`].
struct Line {
    text: &'static str,
    said: Option<Instant>,
}

impl Line {
    const fn new(text: &'static str) -> Self {
        Self { text, said: None }
    }

    fn say(&mut self) {
        if self.said.is_none_or(|at| at.elapsed() >= LINE_PERIOD)
            && NEWS.try_send(News::Line(self.text)).is_ok()
        {
            self.said = Some(Instant::now());
        }
    }
}

/// What has been told, and the lines for the rest.
pub struct Reporter {
    told: Statistics,
    stuck: Line,
    failed: Line,
    interrupt: Line,
    off: Line,
    back: Line,
    passive: Line,
}

impl Default for Reporter {
    fn default() -> Self {
        Self {
            told: Statistics::default(),
            stuck: Line::new(
                "CAN: MCP2515 does not go on the bus: RX low, or its transceiver has no supply",
            ),
            failed: Line::new("CAN: MCP2515 was lost or reset, it is started again"),
            interrupt: Line::new(
                "CAN: INT is low without a reason: shorted? The bus is left alone",
            ),
            off: Line::new("CAN: bus off: check wires, termination and bit rate"),
            back: Line::new("CAN: back on the bus"),
            passive: Line::new("CAN: error passive: nobody acknowledges, or the bit rate differs"),
        }
    }
}

impl Reporter {
    pub fn stuck(&mut self) {
        self.stuck.say();
    }

    pub fn failed(&mut self) {
        self.failed.say();
    }

    pub fn interrupt_stuck(&mut self) {
        self.interrupt.say();
    }

    /// What has come since the last time that it could be told.
    pub fn watch(&mut self, now: &Statistics) {
        // All or nothing: these are the most that can come below.
        if NEWS.free_capacity() < MOST_NEWS {
            return;
        }
        let change = now.since(&self.told);
        self.told = *now;
        let detail = now.summary();
        if change.message_errors > 0 {
            let _ = NEWS.try_send(News::Errors(change.message_errors));
        }
        for (times, code) in [
            (change.overflows, fault_code::RECEIVE_OVERFLOW),
            (
                change.bus_off.max(change.abandoned),
                fault_code::TRANSMIT_OVERFLOW,
            ),
        ] {
            if times > 0 {
                let _ = NEWS.try_send(News::Fault {
                    code,
                    times,
                    detail,
                });
            }
        }
        if change.bus_off > 0 {
            self.off.say();
        }
        if change.passive > 0 {
            self.passive.say();
        }
        if change.recovered {
            self.back.say();
        }
    }
}
