//! Async driver of the inertial sensor LSM6DSO (datasheet DS12140), over any [`I2c`].
//!
//! It is asked, it does not interrupt: [`Lsm6dso::start`] looks for it at both of its addresses and sets it up,
//! [`Lsm6dso::read`] takes one burst of all that it measures. Neither waits for anything but the bus, whose transfers the
//! user bounds in time. Nothing here panics.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![deny(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::unreachable
)]

use embedded_hal_async::i2c::I2c;

/// SA0 low and high.
const ADDRESSES: [u8; 2] = [0x6a, 0x6b];
const WHO_AM_I: u8 = 0x0f;
const IDENTITY: u8 = 0x6c;
/// Accelerometer: 833 Hz, 2 g. Gyroscope: 833 Hz, 250 deg/s. Then: whole samples only, addresses count up.
const CTRL1_XL: u8 = 0x10;
const SETTINGS: [u8; 3] = [0x70, 0x70, BDU | IF_INC];
const CTRL3_C: u8 = 0x12;
const BDU: u8 = 1 << 6;
const IF_INC: u8 = 1 << 2;
const SW_RESET: u8 = 1 << 0;
/// Questions after a reset until it is over; it takes 50 us, as long as one question.
const RESET_QUESTIONS: usize = 10;
const OUT_TEMP_L: u8 = 0x20;

/// One reading, along the sensor's own axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// 8.75 mdeg/s a step.
    pub gyro: [i16; 3],
    /// 0.061 mg a step.
    pub acceleration: [i16; 3],
    /// 1/256 K a step, from 25 degrees Celsius.
    pub temperature: i16,
}

/// Why there is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The bus, or nobody acknowledges.
    Bus(E),
    /// Somebody answers who is no LSM6DSO.
    Stranger(u8),
    /// It does not keep its settings.
    Stubborn,
}

/// The sensor on its bus.
#[derive(Debug)]
pub struct Lsm6dso<B> {
    bus: B,
    address: u8,
}

impl<B: I2c> Lsm6dso<B> {
    /// A bus on which it may be.
    pub fn new(bus: B) -> Self {
        let [address, _] = ADDRESSES;
        Self { bus, address }
    }

    /// Finds it, resets it and begins to measure.
    pub async fn start(&mut self) -> Result<(), Error<B::Error>> {
        let mut found = Err(Error::Stubborn);
        for address in ADDRESSES {
            self.address = address;
            found = self.identify().await;
            if found.is_ok() {
                break;
            }
        }
        found?;
        self.write(&[CTRL3_C, SW_RESET]).await?;
        for _ in 0..RESET_QUESTIONS {
            let [control] = self.registers(CTRL3_C).await?;
            if control & SW_RESET == 0 {
                let [a, b, c] = SETTINGS;
                self.write(&[CTRL1_XL, a, b, c]).await?;
                return match self.registers(CTRL1_XL).await? == SETTINGS {
                    true => Ok(()),
                    false => Err(Error::Stubborn),
                };
            }
        }
        Err(Error::Stubborn)
    }

    /// The newest of all that it measures.
    pub async fn read(&mut self) -> Result<Reading, Error<B::Error>> {
        let [t0, t1, gx0, gx1, gy0, gy1, gz0, gz1, ax0, ax1, ay0, ay1, az0, az1] =
            self.registers(OUT_TEMP_L).await?;
        let word = |low, high| i16::from_le_bytes([low, high]);
        Ok(Reading {
            gyro: [word(gx0, gx1), word(gy0, gy1), word(gz0, gz1)],
            acceleration: [word(ax0, ax1), word(ay0, ay1), word(az0, az1)],
            temperature: word(t0, t1),
        })
    }

    async fn identify(&mut self) -> Result<(), Error<B::Error>> {
        match self.registers(WHO_AM_I).await? {
            [IDENTITY] => Ok(()),
            [other] => Err(Error::Stranger(other)),
        }
    }

    async fn registers<const N: usize>(&mut self, first: u8) -> Result<[u8; N], Error<B::Error>> {
        let mut values = [0; N];
        let first = [first];
        let question = self.bus.write_read(self.address, &first, &mut values);
        question.await.map_err(Error::Bus)?;
        Ok(values)
    }

    async fn write(&mut self, bytes: &[u8]) -> Result<(), Error<B::Error>> {
        let written = self.bus.write(self.address, bytes);
        written.await.map_err(Error::Bus)
    }
}
