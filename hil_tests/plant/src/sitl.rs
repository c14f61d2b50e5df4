//! The firmware on the desktop: one request and one reply per tick over a pair of pipes.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::os::fd::{BorrowedFd, RawFd};

use rover_protocol::rig_tick::{TickReply, TickRequest, BUZZER, LED, NO_SENSOR, POWERED};

use crate::drive::Bridge;
use crate::sonar::Echo;

/// What the firmware's peripherals read at a tick.
pub struct Sensors {
    pub now_us: u64,
    pub counts: [i32; 2],
    pub echo: Option<Echo>,
    /// The echo that the sensor which was triggered at the last tick is going to hear.
    pub ping: Option<Echo>,
    pub battery_mv: u16,
    pub emergency_stop: bool,
    /// Bytes of the host that have come over the serial wire so far.
    pub host_bytes_due: u64,
}

/// What the firmware's peripherals do until the next tick.
pub struct Actuators {
    pub bridge: Bridge,
    pub led: bool,
    pub buzzer: bool,
    pub sonar_trigger: Option<u8>,
    /// Bytes that the firmware has sent over the serial wire so far.
    pub bytes_sent: u64,
}

pub struct Sitl {
    requests: File,
    replies: File,
    /// Requests and replies as they went over the pipes, one after the other; None when nobody wants them.
    pub log: Option<Vec<u8>>,
}

impl Sitl {
    /// Takes duplicates of the write end of the process's stdin and the read end of its stdout.
    pub fn attach(stdin: RawFd, stdout: RawFd) -> Result<Self> {
        let duplicate = |fd: RawFd| -> Result<File> {
            if fd < 0 {
                return Err(Error::new(
                    ErrorKind::InvalidInput,
                    "negative file descriptor",
                ));
            }
            // SAFETY: the caller keeps the descriptor open for the duration of this call; only the copy is kept.
            let borrowed = unsafe { BorrowedFd::borrow_raw(fd) };
            Ok(File::from(borrowed.try_clone_to_owned()?))
        };
        Ok(Self {
            requests: duplicate(stdin)?,
            replies: duplicate(stdout)?,
            log: None,
        })
    }

    /// One tick of the firmware.
    pub fn exchange(&mut self, sensors: &Sensors) -> Result<Actuators> {
        let request = sensors.request().write();
        self.requests.write_all(&request).map_err(ended)?;
        let mut reply = [0_u8; TickReply::SIZE];
        self.replies.read_exact(&mut reply).map_err(ended)?;
        if let Some(log) = &mut self.log {
            log.extend_from_slice(&request);
            log.extend_from_slice(&reply);
        }
        Ok(Actuators::from(TickReply::read(&reply)))
    }
}

impl Sensors {
    fn request(&self) -> TickRequest {
        TickRequest {
            now_us: self.now_us,
            encoder_left: self.counts[0],
            encoder_right: self.counts[1],
            echo_us: self.echo.map_or(0, |echo| echo.echo_us),
            battery_mv: self.battery_mv,
            echo_sensor: self.echo.map_or(NO_SENSOR, |echo| echo.sensor),
            emergency_stop: u8::from(self.emergency_stop),
            host_bytes_due: self.host_bytes_due,
            ping: self.ping.map_or(0, |ping| ping.sensor + 1),
            ping_echo_us: self.ping.map_or(0, |ping| ping.echo_us),
        }
    }
}

impl From<TickReply> for Actuators {
    fn from(reply: TickReply) -> Self {
        Self {
            bridge: Bridge {
                duty: [reply.duty_left, reply.duty_right].map(|duty| f64::from(duty) / 32_768.0),
                powered: reply.flags & POWERED != 0,
            },
            led: reply.flags & LED != 0,
            buzzer: reply.flags & BUZZER != 0,
            sonar_trigger: (reply.sonar_trigger != NO_SENSOR).then_some(reply.sonar_trigger),
            bytes_sent: reply.bytes_sent,
        }
    }
}

fn ended(error: Error) -> Error {
    match error.kind() {
        ErrorKind::BrokenPipe | ErrorKind::UnexpectedEof => {
            Error::new(ErrorKind::BrokenPipe, "rover-sitl has ended")
        }
        _ => error,
    }
}
