//! The firmware on the desktop: one request and one reply per tick over a pair of pipes.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::os::fd::{BorrowedFd, RawFd};

use rover_protocol::rig_tick::{TickReply, TickRequest, BUZZER, LED, NO_SENSOR, POWERED};

use crate::drive::Bridge;
use crate::inertial::Registers;
use crate::sonar::Echo;

/// What the firmware's peripherals read at a tick.
pub struct Sensors {
    /// Time since the firmware's start, µs.
    pub now_us: u64,
    /// x4 quadrature counts, left and right.
    pub counts: [i32; 2],
    /// The echo that has ended by now.
    pub echo: Option<Echo>,
    /// The echo that the sensor which was triggered at the last tick is going to hear.
    pub ping: Option<Echo>,
    /// Battery as the converter reads it, mV.
    pub battery_mv: u16,
    /// Whether the emergency stop is pressed.
    pub emergency_stop: bool,
    /// Whether a switch of the bumper is pressed.
    pub bumper: bool,
    /// As in the request: 0 without an inertial sensor that answers.
    pub inertial: u8,
    /// What that has in its registers.
    pub registers: Registers,
    /// Bytes of the host that have come over the serial wire so far.
    pub host_bytes_due: u64,
}

/// What the firmware's peripherals do until the next tick.
pub struct Actuators {
    /// Both motors.
    pub bridge: Bridge,
    /// Whether the lamp is lit.
    pub led: bool,
    /// Whether the buzzer sounds.
    pub buzzer: bool,
    /// The sonar that is to ping now.
    pub sonar_trigger: Option<u8>,
    /// Bytes that the firmware has sent over the serial wire so far.
    pub bytes_sent: u64,
}

/// A firmware process at the other end of two pipes.
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
            bumper: u8::from(self.bumper),
            inertial: self.inertial,
            gyro_x: self.registers.gyro[0],
            gyro_y: self.registers.gyro[1],
            gyro_z: self.registers.gyro[2],
            acceleration_x: self.registers.acceleration[0],
            acceleration_y: self.registers.acceleration[1],
            acceleration_z: self.registers.acceleration[2],
            temperature: self.registers.temperature,
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

#[cfg(test)]
mod tests {
    use std::io::{Seek, SeekFrom};
    use std::os::fd::AsRawFd;

    use super::*;

    fn sensors() -> Sensors {
        Sensors {
            now_us: 7000,
            counts: [-1, 2],
            echo: None,
            ping: Some(Echo {
                sensor: 1,
                echo_us: 5800,
            }),
            battery_mv: 7400,
            emergency_stop: true,
            bumper: false,
            inertial: 0,
            registers: Registers::default(),
            host_bytes_due: 9,
        }
    }

    #[test]
    fn a_request_says_which_sensors_have_spoken() {
        let request = sensors().request();
        assert_eq!((request.echo_sensor, request.echo_us), (NO_SENSOR, 0));
        assert_eq!((request.ping, request.ping_echo_us), (2, 5800));
        let echo = Some(Echo {
            sensor: 0,
            echo_us: 100,
        });
        let request = Sensors {
            echo,
            ping: None,
            ..sensors()
        }
        .request();
        assert_eq!(
            (request.echo_sensor, request.echo_us, request.ping),
            (0, 100, 0)
        );
    }

    #[test]
    fn a_reply_becomes_what_the_bridges_do() {
        let reply = TickReply {
            duty_left: i16::MIN,
            duty_right: 16_384,
            flags: POWERED | BUZZER,
            sonar_trigger: NO_SENSOR,
            bytes_sent: 3,
        };
        let actuators = Actuators::from(reply);
        assert_eq!(actuators.bridge.duty, [-1.0, 0.5]);
        assert!(actuators.bridge.powered && actuators.buzzer && !actuators.led);
        assert_eq!((actuators.sonar_trigger, actuators.bytes_sent), (None, 3));
    }

    #[test]
    fn a_firmware_that_ends_is_a_broken_pipe_and_a_bad_descriptor_is_refused() {
        let folder = std::env::temp_dir().join(format!("plant-sitl-{}", std::process::id()));
        let mut file = File::options()
            .create(true)
            .truncate(true)
            .read(true)
            .write(true)
            .open(&folder)
            .unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        let mut sitl = Sitl::attach(
            file.as_raw_fd(),
            File::open("/dev/null").unwrap().as_raw_fd(),
        )
        .unwrap();
        let error = sitl.exchange(&sensors()).err().unwrap();
        assert_eq!(error.kind(), ErrorKind::BrokenPipe);
        assert!(error.to_string().contains("rover-sitl has ended"));
        std::fs::remove_file(folder).unwrap();
        assert_eq!(
            Sitl::attach(-1, 0).err().unwrap().kind(),
            ErrorKind::InvalidInput
        );
    }
}
