//! The chip itself: start, interrupts, sending, and looking after it.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::{Operation, SpiDevice};

use crate::frame::{identifier_image, IMAGE};
use crate::registers as r;
use crate::transmit_order::{place, Place, Waiting, BUFFERS};
use crate::{Acceptance, BitTiming, BusState, Frame, Statistics};

/// The oscillator runs after 128 periods (16 us at 8 MHz); a crystal needs some milliseconds to swing up after power-on.
const RESET_POLLS: u32 = 10;
const RESET_POLL_US: u32 = 1_000;
/// Changing the mode waits for the end of a frame on the bus: 1 ms at 125 kbit/s.
const MODE_POLLS: u32 = 20;
const MODE_POLL_US: u32 = 500;
/// Rounds of one [`Mcp2515::service`], more than a full bus brings in that time.
const SERVICE_ROUNDS: u32 = 8;

/// What a chip is started with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// From the board's crystal and the bus.
    pub timing: BitTiming,
    /// What is to be received.
    pub acceptance: Acceptance,
}

/// Why the chip can't be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The SPI bus failed.
    Spi(E),
    /// No answer, or not that of an MCP2515.
    Absent,
    /// It does not leave configuration mode: the receive line is held low, or the transceiver has no supply.
    BusStuck,
    /// It was running and has lost its configuration. Start it again.
    Lost,
}

impl<E> From<E> for Error<E> {
    fn from(error: E) -> Self {
        Self::Spi(error)
    }
}

/// One chip. SPI mode 0, at most 10 MHz.
#[derive(Debug)]
pub struct Mcp2515<S> {
    spi: S,
    configuration: Configuration,
    waiting: [Option<Waiting>; BUFFERS],
    statistics: Statistics,
}

impl<S: SpiDevice> Mcp2515<S> {
    /// A chip that has not been spoken to.
    pub fn new(spi: S, configuration: Configuration) -> Self {
        Self {
            spi,
            configuration,
            waiting: [None; BUFFERS],
            statistics: Statistics::default(),
        }
    }

    /// Counters and the state of the bus at the last look.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Reset, configure and go on the bus. Also for a chip that was lost. Takes 20 ms at most.
    pub async fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), Error<S::Error>> {
        self.waiting = [None; BUFFERS];
        self.statistics.state = BusState::Active;
        self.spi.write(&[r::RESET]).await?;
        self.await_reset(delay).await?;
        self.write_acceptance().await?;
        let expected = self.expected();
        let [cnf3, cnf2, cnf1, enabled] = expected;
        self.spi
            .write(&[r::WRITE, r::CNF3, cnf3, cnf2, cnf1, enabled])
            .await?;
        self.spi
            .write(&[r::WRITE, r::RXB0CTRL, r::ROLLOVER])
            .await?;
        self.spi.write(&[r::WRITE, r::RXB1CTRL, 0]).await?;
        if self.read::<4>(r::CNF3).await? != expected {
            return Err(Error::Absent);
        }
        self.spi
            .write(&[r::WRITE, r::CANCTRL, r::NORMAL_MODE])
            .await?;
        for _ in 0..MODE_POLLS {
            let [status, control] = self.status().await?;
            if control == r::NORMAL_MODE && status & r::MODE_MASK == r::NORMAL_MODE {
                return Ok(());
            }
            delay.delay_us(MODE_POLL_US).await;
        }
        Err(Error::BusStuck)
    }

    /// What the INT pin asks for. Each frame goes to `taken`. False when there was nothing to be done: then the chip
    /// does not hold the pin low, whoever does.
    ///
    /// Read frames come in the order of the buffers; while one is read another may come into the other buffer, so two
    /// that are less than a transfer apart may change places.
    pub async fn service(&mut self, mut taken: impl FnMut(Frame)) -> Result<bool, Error<S::Error>> {
        for round in 0..SERVICE_ROUNDS {
            let [flags, error_flags] = self.read::<2>(r::CANINTF).await?;
            if flags & (r::ENABLED | r::MESSAGE_ERROR) == 0 {
                return Ok(round > 0);
            }
            for (buffer, flag) in r::RECEIVED.iter().enumerate() {
                if flags & flag != 0 {
                    self.receive(buffer as u8, &mut taken).await?;
                }
            }
            self.finish(flags).await?;
            if flags & (r::ERROR | r::MESSAGE_ERROR) != 0 {
                self.note_errors(flags, error_flags).await?;
            }
        }
        // Still something: a very noisy bus, or a line that always reads high.
        self.watch().await?;
        Ok(true)
    }

    /// Whether a frame with that identifier may be sent now: there is a buffer, and in it nothing gets out of order.
    pub fn has_room(&self, identifier: u16) -> bool {
        self.statistics.state != BusState::Off && place(identifier, &self.waiting).is_some()
    }

    /// Hand a frame to the chip; false when it has no room for it (see [`Mcp2515::has_room`]).
    pub async fn send(&mut self, frame: &Frame) -> Result<bool, Error<S::Error>> {
        if self.statistics.state == BusState::Off {
            return Ok(false);
        }
        let Some(Place { buffer, priority }) = place(frame.identifier(), &self.waiting) else {
            return Ok(false);
        };
        let control = r::TXB0CTRL + buffer as u8 * r::TRANSMIT_BUFFER_STEP;
        self.spi
            .transaction(&mut [
                Operation::Write(&[r::WRITE, control, priority]),
                Operation::Write(&frame.image()),
            ])
            .await?;
        self.spi.write(&[r::REQUEST_TO_SEND | 1 << buffer]).await?;
        if let Some(slot) = self.waiting.get_mut(buffer) {
            *slot = Some(Waiting {
                identifier: frame.identifier(),
                priority,
            });
        }
        Ok(true)
    }

    /// Look after the chip, a few times a second: is it there with its configuration, how does it stand to the bus?
    /// Leaving bus-off raises no interrupt and is seen here.
    pub async fn watch(&mut self) -> Result<(), Error<S::Error>> {
        let [cnf3, cnf2, cnf1, enabled, flags, error_flags] = self.read::<6>(r::CNF3).await?;
        let [status, _] = self.status().await?;
        if [cnf3, cnf2, cnf1, enabled] != self.expected() || status & r::MODE_MASK != r::NORMAL_MODE
        {
            return Err(self.lost());
        }
        // Faults of frames raise no interrupt of their own: on a noisy bus it would never rest.
        if flags & r::MESSAGE_ERROR != 0 {
            self.note_errors(flags, error_flags).await
        } else {
            self.look(error_flags).await
        }
    }

    /// After a reset the chip is in configuration mode, and CANCTRL has a value that no floating line gives.
    async fn await_reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Error<S::Error>> {
        for _ in 0..RESET_POLLS {
            delay.delay_us(RESET_POLL_US).await;
            let [_, control] = self.status().await?;
            if control == r::CANCTRL_AFTER_RESET {
                return Ok(());
            }
        }
        Err(Error::Absent)
    }

    async fn write_acceptance(&mut self) -> Result<(), Error<S::Error>> {
        let Acceptance { masks, filters } = self.configuration.acceptance;
        let masks = r::MASKS.into_iter().zip(masks);
        for (address, identifier) in masks.chain(r::FILTERS.into_iter().zip(filters)) {
            let [high, low] = identifier_image(identifier);
            self.spi
                .write(&[r::WRITE, address, high, low, 0, 0])
                .await?;
        }
        Ok(())
    }

    /// CNF3, CNF2, CNF1 and CANINTE as they are written.
    fn expected(&self) -> [u8; 4] {
        let BitTiming { cnf1, cnf2, cnf3 } = self.configuration.timing;
        [cnf3, cnf2, cnf1, r::ENABLED]
    }

    async fn receive(
        &mut self,
        buffer: u8,
        taken: &mut impl FnMut(Frame),
    ) -> Result<(), Error<S::Error>> {
        let mut image = [0; IMAGE];
        self.spi
            .transaction(&mut [
                Operation::Write(&[r::READ_RECEIVE_BUFFER | buffer << 2]),
                Operation::Read(&mut image),
            ])
            .await?;
        match Frame::from_image(&image) {
            Some(frame) => {
                self.statistics.received = self.statistics.received.wrapping_add(1);
                taken(frame);
            }
            None => self.statistics.foreign = self.statistics.foreign.wrapping_add(1),
        }
        Ok(())
    }

    /// Buffers whose frame has been sent are free again.
    async fn finish(&mut self, flags: u8) -> Result<(), Error<S::Error>> {
        let mut done = 0;
        for (flag, waiting) in r::SENT.iter().zip(&mut self.waiting) {
            if flags & flag != 0 {
                done |= flag;
                *waiting = None;
                self.statistics.sent = self.statistics.sent.wrapping_add(1);
            }
        }
        if done != 0 {
            self.modify(r::CANINTF, done, 0).await?;
        }
        Ok(())
    }

    async fn note_errors(&mut self, flags: u8, error_flags: u8) -> Result<(), Error<S::Error>> {
        if flags & r::MESSAGE_ERROR != 0 {
            self.statistics.message_errors = self.statistics.message_errors.wrapping_add(1);
        }
        // Flags first: what comes after this raises the interrupt again.
        self.modify(r::CANINTF, flags & (r::ERROR | r::MESSAGE_ERROR), 0)
            .await?;
        let [first, second] = r::OVERFLOW;
        let overflow = error_flags & (first | second);
        if overflow != 0 {
            let count = overflow.count_ones() as u16;
            self.statistics.overflows = self.statistics.overflows.wrapping_add(count);
            self.modify(r::EFLG, overflow, 0).await?;
        }
        self.look(error_flags).await
    }

    /// Error counters, and what a change of the bus state means.
    async fn look(&mut self, error_flags: u8) -> Result<(), Error<S::Error>> {
        let [transmit, receive] = self.read::<2>(r::TEC).await?;
        let state = BusState::of(error_flags);
        let before = core::mem::replace(&mut self.statistics.state, state);
        self.statistics.transmit_errors = transmit;
        self.statistics.receive_errors = receive;
        match state {
            BusState::Passive if before != BusState::Passive => {
                self.statistics.passive = self.statistics.passive.wrapping_add(1);
            }
            BusState::Off if before != BusState::Off => {
                self.statistics.bus_off = self.statistics.bus_off.wrapping_add(1);
                self.abandon().await?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Off the bus: what waits would be out of date when it comes back, which the chip does by itself.
    async fn abandon(&mut self) -> Result<(), Error<S::Error>> {
        for buffer in 0..BUFFERS as u8 {
            let control = r::TXB0CTRL + buffer * r::TRANSMIT_BUFFER_STEP;
            self.modify(control, r::TRANSMIT_REQUEST, 0).await?;
        }
        // A flag that is left would be taken for the end of the next frame in that buffer.
        let [first, second, third] = r::SENT;
        self.modify(r::CANINTF, first | second | third, 0).await?;
        let given_up = self.waiting.iter().flatten().count() as u16;
        self.statistics.abandoned = self.statistics.abandoned.wrapping_add(given_up);
        self.waiting = [None; BUFFERS];
        Ok(())
    }

    fn lost(&mut self) -> Error<S::Error> {
        self.statistics.lost_chip = self.statistics.lost_chip.wrapping_add(1);
        Error::Lost
    }

    /// CANSTAT and CANCTRL.
    async fn status(&mut self) -> Result<[u8; 2], Error<S::Error>> {
        self.read::<2>(r::CANCTRL - 1).await
    }

    async fn read<const N: usize>(&mut self, address: u8) -> Result<[u8; N], Error<S::Error>> {
        let mut values = [0; N];
        self.spi
            .transaction(&mut [
                Operation::Write(&[r::READ, address]),
                Operation::Read(&mut values),
            ])
            .await?;
        Ok(values)
    }

    async fn modify(&mut self, address: u8, mask: u8, value: u8) -> Result<(), Error<S::Error>> {
        self.spi
            .write(&[r::BIT_MODIFY, address, mask, value])
            .await?;
        Ok(())
    }
}
