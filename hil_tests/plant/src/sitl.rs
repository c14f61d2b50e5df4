//! The firmware on the desktop: one request and one reply per tick over a pair of pipes, little-endian and packed.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::os::fd::{BorrowedFd, RawFd};

use crate::drive::Bridge;
use crate::sonar::Echo;

const REQUEST: usize = 40;
const REPLY: usize = 16;
const NO_SENSOR: u8 = 255;

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
        let mut request = [0_u8; REQUEST];
        request[0..8].copy_from_slice(&sensors.now_us.to_le_bytes());
        request[8..12].copy_from_slice(&sensors.counts[0].to_le_bytes());
        request[12..16].copy_from_slice(&sensors.counts[1].to_le_bytes());
        request[16..20].copy_from_slice(&sensors.echo.map_or(0, |echo| echo.echo_us).to_le_bytes());
        request[20..22].copy_from_slice(&sensors.battery_mv.to_le_bytes());
        request[22] = sensors.echo.map_or(NO_SENSOR, |echo| echo.sensor);
        request[23] = u8::from(sensors.emergency_stop);
        request[24..32].copy_from_slice(&sensors.host_bytes_due.to_le_bytes());
        if let Some(ping) = sensors.ping {
            request[32] = ping.sensor + 1;
            request[36..40].copy_from_slice(&ping.echo_us.to_le_bytes());
        }
        self.requests.write_all(&request).map_err(ended)?;
        let mut reply = [0_u8; REPLY];
        self.replies.read_exact(&mut reply).map_err(ended)?;
        if let Some(log) = &mut self.log {
            log.extend_from_slice(&request);
            log.extend_from_slice(&reply);
        }
        let duty =
            |low: usize| f64::from(i16::from_le_bytes([reply[low], reply[low + 1]])) / 32_768.0;
        let mut sent = [0_u8; 8];
        sent.copy_from_slice(&reply[8..16]);
        Ok(Actuators {
            bridge: Bridge {
                duty: [duty(0), duty(2)],
                powered: reply[4] & 1 != 0,
            },
            led: reply[4] & 2 != 0,
            buzzer: reply[4] & 4 != 0,
            sonar_trigger: (reply[5] != NO_SENSOR).then_some(reply[5]),
            bytes_sent: u64::from_le_bytes(sent),
        })
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
