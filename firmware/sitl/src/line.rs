//! A descriptor that may be blocking or not, as both ends of a line. A line whose other end is gone is a dead wire, not an
//! error: the firmware goes on and must stop the rover by itself.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Write};
use std::os::fd::{AsFd, FromRawFd, RawFd};

use rustix::event::{poll, PollFd, PollFlags, Timespec};

/// What may wait for a peer that does not read.
const BACKLOG: usize = 4096;

pub struct Line {
    /// None once the other end is gone.
    file: Option<File>,
    received: u64,
    sent: u64,
    backlog: Vec<u8>,
}

impl Line {
    /// Takes the descriptor over.
    pub fn open(descriptor: RawFd) -> Self {
        // SAFETY: the descriptor was handed to this process for this purpose and nothing else here uses it.
        let file = unsafe { File::from_raw_fd(descriptor) };
        Self {
            file: Some(file),
            received: 0,
            sent: 0,
            backlog: Vec::with_capacity(BACKLOG),
        }
    }

    /// Bytes that went out since the start.
    pub fn bytes_sent(&self) -> u64 {
        self.sent
    }

    /// Bytes that `send` still takes.
    pub fn room(&self) -> usize {
        BACKLOG - self.backlog.len()
    }

    /// Take bytes in until `due` have come in total. Waits for them, unless `due` is `u64::MAX`: then it takes what is
    /// there. False when `ticks` (the request pipe) has ended meanwhile.
    pub fn receive(&mut self, due: u64, ticks: &impl AsFd, mut take: impl FnMut(&[u8])) -> bool {
        let mut buffer = [0; 4096];
        while self.received < due {
            let Some(file) = &mut self.file else { break };
            let waiting = if due == u64::MAX {
                Some(&NO_TIME)
            } else {
                None
            };
            let mut ready = [
                PollFd::new(file, PollFlags::IN),
                PollFd::new(ticks, PollFlags::empty()),
            ];
            match poll(&mut ready, waiting) {
                Ok(0) => break,
                Err(rustix::io::Errno::INTR) => continue,
                Err(_) => self.file = None,
                Ok(_) if ready[0].revents().is_empty() => return false,
                Ok(_) => {
                    let room = buffer.len().min((due - self.received).min(4096) as usize);
                    match file.read(&mut buffer[..room]) {
                        Ok(0) => self.file = None,
                        Ok(count) => {
                            self.received += count as u64;
                            take(&buffer[..count]);
                        }
                        Err(error) if temporary(&error) => {}
                        // A pty that nobody has open: someone may come back.
                        Err(error) if hung_up(&error) => break,
                        Err(_) => self.file = None,
                    }
                }
            }
        }
        true
    }

    /// Queue bytes, at most [`Line::room`], and write as far as the line takes them without waiting, whether or not the
    /// descriptor blocks.
    pub fn send(&mut self, bytes: &[u8]) {
        self.backlog.extend_from_slice(bytes);
        while !self.backlog.is_empty() {
            let Some(file) = &mut self.file else {
                self.backlog.clear();
                return;
            };
            let mut ready = [PollFd::new(file, PollFlags::OUT)];
            match poll(&mut ready, Some(&NO_TIME)) {
                Ok(0) => return,
                Err(rustix::io::Errno::INTR) => continue,
                _ => {}
            }
            match file.write(&self.backlog) {
                Ok(0) => return,
                Ok(count) => {
                    self.sent += count as u64;
                    self.backlog.drain(..count);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if temporary(&error) => {}
                // What is sent to nobody is lost, as on a wire.
                Err(error) if hung_up(&error) => self.backlog.clear(),
                Err(_) => self.file = None,
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
