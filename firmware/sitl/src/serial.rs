//! The serial line: a descriptor that may be blocking or not, metered by the baud rate. A line whose other end is gone
//! is a dead wire, not an error: the firmware goes on and must stop the rover by itself.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Write};
use std::os::fd::{AsFd, FromRawFd, RawFd};

use rover_core::Core;
use rustix::event::{poll, PollFd, PollFlags, Timespec};

/// Ten bit times carry a byte.
const BITS_PER_BYTE: u64 = 10;
/// What may wait for a peer that does not read.
const BACKLOG: usize = 4096;

pub struct Serial {
    /// None once the other end is gone.
    line: Option<File>,
    received: u64,
    sent: u64,
    baud: u64,
    last_us: u64,
    /// Bit time saved up towards the next byte, in bits times 1e6.
    credit: u64,
    backlog: Vec<u8>,
}

impl Serial {
    /// Takes the descriptor over.
    pub fn open(descriptor: RawFd, baud: u32) -> Self {
        // SAFETY: the descriptor was handed to this process for this purpose and nothing else here uses it.
        let line = unsafe { File::from_raw_fd(descriptor) };
        Self {
            line: Some(line),
            received: 0,
            sent: 0,
            baud: u64::from(baud),
            last_us: 0,
            credit: 0,
            backlog: Vec::with_capacity(BACKLOG),
        }
    }

    /// Bytes that went out on the line since the start.
    pub fn bytes_sent(&self) -> u64 {
        self.sent
    }

    /// Feed the core until `due` bytes have come in total. Waits for them, unless `due` is `u64::MAX`: then it
    /// takes what is there. False when `ticks` (the request pipe) has ended meanwhile.
    pub fn receive(&mut self, core: &mut Core, due: u64, now_us: u64, ticks: &impl AsFd) -> bool {
        let mut buffer = [0; 4096];
        while self.received < due {
            let Some(line) = &mut self.line else { break };
            let waiting = if due == u64::MAX {
                Some(&NO_TIME)
            } else {
                None
            };
            let mut ready = [
                PollFd::new(line, PollFlags::IN),
                PollFd::new(ticks, PollFlags::empty()),
            ];
            match poll(&mut ready, waiting) {
                Ok(0) => break,
                Err(rustix::io::Errno::INTR) => continue,
                Err(_) => self.line = None,
                Ok(_) if ready[0].revents().is_empty() => return false,
                Ok(_) => {
                    let room = buffer.len().min((due - self.received).min(4096) as usize);
                    match line.read(&mut buffer[..room]) {
                        Ok(0) => self.line = None,
                        Ok(count) => {
                            self.received += count as u64;
                            core.receive(&buffer[..count], now_us);
                        }
                        Err(error) if temporary(&error) => {}
                        // A pty that nobody has open: someone may come back.
                        Err(error) if hung_up(&error) => break,
                        Err(_) => self.line = None,
                    }
                }
            }
        }
        true
    }

    /// Send what the core has to say, as much as the baud rate lets through until `now_us`.
    pub fn transmit(&mut self, core: &mut Core, now_us: u64) {
        let elapsed_us = now_us.saturating_sub(self.last_us).min(100_000);
        self.last_us = now_us;
        self.credit += elapsed_us * self.baud;
        let allowed = self.credit / (BITS_PER_BYTE * 1_000_000);
        let mut buffer = [0; 4096];
        let room = (allowed as usize)
            .min(buffer.len())
            .min(BACKLOG - self.backlog.len());
        let count = core.transmit(&mut buffer[..room]);
        if count < room {
            // An idle wire saves no time up for later.
            self.credit = 0;
        } else {
            self.credit -= allowed * BITS_PER_BYTE * 1_000_000;
        }
        self.backlog.extend_from_slice(&buffer[..count]);
        self.flush();
    }

    /// Write the backlog as far as the line takes it without waiting, whether or not the descriptor blocks.
    fn flush(&mut self) {
        while !self.backlog.is_empty() {
            let Some(line) = &mut self.line else {
                self.backlog.clear();
                return;
            };
            let mut ready = [PollFd::new(line, PollFlags::OUT)];
            match poll(&mut ready, Some(&NO_TIME)) {
                Ok(0) => return,
                Err(rustix::io::Errno::INTR) => continue,
                _ => {}
            }
            match line.write(&self.backlog) {
                Ok(0) => return,
                Ok(count) => {
                    self.sent += count as u64;
                    self.backlog.drain(..count);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if temporary(&error) => {}
                // What is sent to nobody is lost, as on a wire.
                Err(error) if hung_up(&error) => self.backlog.clear(),
                Err(_) => self.line = None,
            }
        }
    }
}

const NO_TIME: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 0,
};

fn temporary(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn hung_up(error: &Error) -> bool {
    error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
}
