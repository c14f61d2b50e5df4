//! The CAN bus: frames between the control loop and an MCP2515.
//!
//! Below the control loop, in the thread executor. A chip that does not answer at the start is taken as not fitted; one
//! that is lost later, or whose INT is low without a reason, is left alone for a second and started again. The others of
//! the executor have their turn in each round, whatever the chip does.

use core::convert::Infallible;

use embassy_futures::select::{select, Either};
use embassy_futures::yield_now;
use embassy_rp::gpio::{Input, Output};
use embassy_rp::peripherals::SPI0;
use embassy_rp::spi::{Blocking, Config, Error as SpiError, Spi};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{with_timeout, Delay, Duration, Instant, Timer};
use embedded_hal_async::spi::{ErrorType, Operation, SpiDevice};
use rover_core::Core;
use rover_mcp2515::{Acceptance, BitTiming, BusState, Configuration, Error, Frame, Mcp2515};
use rover_protocol::{messages, Message};

use crate::can_report::{self, Reporter};
use crate::crash::{self, task};
use crate::life;
use crate::overrun::Overrun;
use crate::pins::{CanPins, CAN_BITRATE, CAN_CRYSTAL};

/// The MCP2515 takes 10 MHz.
const SPI_HZ: u32 = 10_000_000;
const WATCH: Duration = Duration::from_millis(100);
const RESTART: Duration = Duration::from_millis(1_000);
/// Rounds in a row in which INT is low and nothing is to be done; one happens when a frame comes while INT rises.
const IDLE_ROUNDS: u32 = 8;

/// Commands of motion and safety have identifiers below 0x080, those of the handshake and of parameters 0x100 to 0x17f;
/// Reboot has a filter of its own. What other nodes say to each other elsewhere costs no time here.
const ACCEPTANCE: Acceptance = Acceptance {
    masks: [0x780, 0x7ff],
    filters: [
        0x000,
        0x100,
        messages::Reboot::ID,
        messages::Reboot::ID,
        messages::Reboot::ID,
        messages::Reboot::ID,
    ],
};

/// What a companion sends must come in.
const COMPANION: [u16; 14] = [
    messages::EmergencyStop::ID,
    messages::Stop::ID,
    messages::Arm::ID,
    messages::Disarm::ID,
    messages::KeepAlive::ID,
    messages::ClockRequest::ID,
    messages::SegmentTravel::ID,
    messages::SegmentHeading::ID,
    messages::SegmentStart::ID,
    messages::Hello::ID,
    messages::ParameterGet::ID,
    messages::ParameterSet::ID,
    messages::ParameterCommand::ID,
    messages::TelemetryRate::ID,
];
const _: () = {
    let mut i = 0;
    while i < COMPANION.len() {
        assert!(ACCEPTANCE.accepts(COMPANION[i]));
        i += 1;
    }
    assert!(ACCEPTANCE.accepts(messages::Reboot::ID));
};

/// A frame and when its interrupt was answered.
pub struct Received {
    pub frame: Frame,
    pub time_us: u64,
}

/// To the control loop, which empties it in each tick: more than 500 kbit/s bring in one.
pub static RECEIVED: Channel<CriticalSectionRawMutex, Received, 16> = Channel::new();
/// From the control loop. Short, so that what is queued is decided in the core and not hidden here.
static OUTGOING: Channel<CriticalSectionRawMutex, Frame, 4> = Channel::new();
/// Frames were lost because nobody took them in time.
pub static LOST: Overrun = Overrun::new();
/// What passes the bus within a millisecond even when the companion sends as much: what is said in one tick is then
/// with the companion before the next tick's is. As in firmware/sitl/src/can_adapter.rs.
const FRAMES_PER_TICK: usize = 2;

/// As many frames of the core as a tick may send and as there is room for.
pub fn send(core: &mut Core) {
    for _ in 0..FRAMES_PER_TICK {
        if OUTGOING.is_full() {
            return;
        }
        let Some(outgoing) = core.transmit_frame() else {
            return;
        };
        // Identifiers have 11 bits and payloads 8 bytes at most, and there is room.
        if let Some(frame) = Frame::new(outgoing.identifier, outgoing.payload()) {
            let _ = OUTGOING.try_send(frame);
        }
    }
}

/// SPI with chip select. Transfers are short, 14 bytes in 12 us: the processor does them itself, as setting up DMA and
/// waiting for its interrupt would take longer. The control loop interrupts them when it has to.
struct Bus {
    spi: Spi<'static, SPI0, Blocking>,
    select: Output<'static>,
}

impl ErrorType for Bus {
    type Error = SpiError;
}

impl SpiDevice for Bus {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), SpiError> {
        self.select.set_low();
        let done = operations
            .iter_mut()
            .try_for_each(|operation| match operation {
                Operation::Read(bytes) => self.spi.blocking_read(bytes),
                Operation::Write(bytes) => self.spi.blocking_write(bytes),
                Operation::Transfer(read, write) => self.spi.blocking_transfer(read, write),
                Operation::TransferInPlace(bytes) => self.spi.blocking_transfer_in_place(bytes),
                Operation::DelayNs(nanoseconds) => {
                    embassy_time::block_for(Duration::from_nanos(u64::from(*nanoseconds)));
                    Ok(())
                }
            });
        let flushed = self.spi.flush();
        self.select.set_high();
        done.and(flushed)
    }
}

type Chip = Mcp2515<Bus>;

#[embassy_executor::task]
pub async fn run(pins: CanPins) {
    crash::within(task::CAN, work_the_bus(pins)).await
}

async fn work_the_bus(pins: CanPins) {
    let mut config = Config::default();
    config.frequency = SPI_HZ;
    let bus = Bus {
        spi: Spi::new_blocking(pins.spi, pins.clock, pins.mosi, pins.miso, config),
        select: pins.select,
    };
    let mut chip = Chip::new(
        bus,
        Configuration {
            timing: BitTiming::new(CAN_CRYSTAL, CAN_BITRATE),
            acceptance: ACCEPTANCE,
        },
    );
    let mut interrupt = pins.interrupt;
    let mut started = chip.start(&mut Delay).await;
    if started == Err(Error::Absent) {
        can_report::note_absent();
        life::CAN.retire();
        return;
    }
    let mut reporter = Reporter::default();
    loop {
        match started {
            Ok(()) => match serve(&mut chip, &mut interrupt, &mut reporter).await {
                Failure::Chip => reporter.failed(),
                Failure::Interrupt => reporter.interrupt_stuck(),
            },
            Err(Error::BusStuck) => reporter.stuck(),
            Err(_) => reporter.failed(),
        }
        reporter.watch(chip.statistics());
        rest().await;
        started = chip.start(&mut Delay).await;
    }
}

/// Wait before the next try; what the core has to say meanwhile is dropped, as on a cable that is cut.
async fn rest() {
    let until = Instant::now() + RESTART;
    while Instant::now() < until {
        life::CAN.show();
        while OUTGOING.try_receive().is_ok() {}
        Timer::after(life::IDLE).await;
    }
}

/// Why the chip is left alone for a while.
enum Failure {
    Chip,
    /// INT is low and the chip does not hold it: shorted to ground.
    Interrupt,
}

impl From<Error<SpiError>> for Failure {
    fn from(_: Error<SpiError>) -> Self {
        Self::Chip
    }
}

async fn serve(
    chip: &mut Chip,
    interrupt: &mut Input<'static>,
    reporter: &mut Reporter,
) -> Failure {
    match work(chip, interrupt, reporter).await {
        Err(failure) => failure,
        Ok(never) => match never {},
    }
}

/// Both directions, until the chip fails.
async fn work(
    chip: &mut Chip,
    interrupt: &mut Input<'static>,
    reporter: &mut Reporter,
) -> Result<Infallible, Failure> {
    let mut held: Option<Frame> = None;
    let mut watched = Instant::now();
    let mut idle = 0;
    loop {
        life::CAN.show();
        yield_now().await;
        match with_timeout(life::IDLE, next(interrupt, held.is_none())).await {
            Ok(Either::First(())) => {
                let time_us = Instant::now().as_micros();
                let taken = |frame| {
                    if RECEIVED.try_send(Received { frame, time_us }).is_err() {
                        LOST.note();
                    }
                };
                idle = match chip.service(taken).await? {
                    true => 0,
                    false => idle + 1,
                };
                if idle >= IDLE_ROUNDS {
                    return Err(Failure::Interrupt);
                }
            }
            Ok(Either::Second(frame)) => held = Some(frame),
            Err(_) => {}
        }
        if let Some(frame) = &held {
            // Off the bus nothing is kept for later.
            if chip.send(frame).await? || chip.statistics().state == BusState::Off {
                held = None;
            }
        }
        if watched.elapsed() >= WATCH {
            watched = Instant::now();
            chip.watch().await?;
            reporter.watch(chip.statistics());
        }
    }
}

/// The chip's interrupt, or a frame to send if one is wanted.
async fn next(interrupt: &mut Input<'static>, wanted: bool) -> Either<(), Frame> {
    if wanted {
        select(interrupt.wait_for_low(), OUTGOING.receive()).await
    } else {
        interrupt.wait_for_low().await;
        Either::First(())
    }
}
