//! The command line of `rover-sitl`.

use std::os::fd::RawFd;
use std::path::PathBuf;

use rover_core::reset_cause;

pub const USAGE: &str = "\
usage: rover-sitl --serial-fd N [--wire serial|can] [--baud 230400] [--git-hash HEX] [--parameters FILE]
                  [--reset-cause power-on|watchdog|software|brown-out|unknown] [--statistics]

Runs the rover's firmware in virtual time: one 40-byte request on stdin is one millisecond, answered by one
16-byte reply on stdout. N is an open descriptor of the companion's line (a pty's master or a socket).
With --wire can it is the line of a serial CAN adapter (slcan, ASCII) on a bus of 500 kbit/s: O opens the channel,
S6 is the only bit rate, and --baud counts only for the host's bytes that a request announces.
With --parameters, saved parameters are kept in FILE, which is made if it does not exist.
With --reset-cause the firmware says that it was started for that reason; power-on when left out.
Ends when stdin ends; with --statistics it then says on stderr what went over the wire.";

/// Bits per second of the serial line when nothing else is said.
pub const DEFAULT_BAUD: u32 = 230_400;

/// What the companion is connected by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WireKind {
    #[default]
    Serial,
    Can,
}

/// What the process was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    pub wire: WireKind,
    pub serial: RawFd,
    /// Bits per second; ten of them carry a byte.
    pub baud: u32,
    pub git_hash: u32,
    /// Say at the end what went over the wire.
    pub statistics: bool,
    /// Where saved parameters are kept; without, a save fails.
    pub parameters: Option<PathBuf>,
    /// Why the firmware is started, one of [`reset_cause`].
    pub reset_cause: u8,
}

impl Options {
    /// Parse the arguments after the program's name. `built_hash` is the commit the program was built from, if known;
    /// a build that did not know it has hash 0.
    pub fn parse(
        arguments: impl Iterator<Item = String>,
        built_hash: Option<&str>,
    ) -> Result<Self, String> {
        let mut arguments = arguments;
        let mut serial = None;
        let mut statistics = false;
        let mut wire = WireKind::default();
        let mut parameters = None;
        let mut baud = DEFAULT_BAUD;
        let mut reset_cause = reset_cause::POWER_ON;
        let mut git_hash = built_hash.map_or(0, |hash| parse_hash(hash).unwrap_or(0));
        while let Some(name) = arguments.next() {
            if name == "--statistics" {
                statistics = true;
                continue;
            }
            let value = arguments
                .next()
                .ok_or_else(|| format!("{name} needs a value"))?;
            let number = |low: u32| match value.parse::<u32>() {
                Ok(number) if number >= low => Ok(number),
                _ => Err(format!("{name}: {value} is not a number from {low} up")),
            };
            match name.as_str() {
                "--serial-fd" => serial = Some(number(0)? as RawFd),
                "--wire" => {
                    wire = match value.as_str() {
                        "serial" => WireKind::Serial,
                        "can" => WireKind::Can,
                        _ => return Err(format!("--wire: {value} is not serial or can")),
                    }
                }
                "--baud" => baud = number(1200)?,
                "--parameters" => parameters = Some(PathBuf::from(&value)),
                "--git-hash" => git_hash = parse_hash(&value)?,
                "--reset-cause" => reset_cause = parse_reset_cause(&value)?,
                _ => return Err(format!("{name} is not known")),
            }
        }
        match serial {
            Some(serial @ 0..=1) => Err(format!("--serial-fd: {serial} carries the ticks")),
            Some(serial) if serial >= 2 => Ok(Self {
                statistics,
                wire,
                serial,
                baud,
                git_hash,
                parameters,
                reset_cause,
            }),
            _ => Err("--serial-fd is missing".into()),
        }
    }
}

/// First 32 bits of a commit given as at least 8 hexadecimal digits.
fn parse_hash(text: &str) -> Result<u32, String> {
    text.get(..8)
        .and_then(|digits| u32::from_str_radix(digits, 16).ok())
        .ok_or_else(|| format!("{text} is not a commit: at least 8 hexadecimal digits"))
}

fn parse_reset_cause(word: &str) -> Result<u8, String> {
    match word {
        "power-on" => Ok(reset_cause::POWER_ON),
        "watchdog" => Ok(reset_cause::WATCHDOG),
        "software" => Ok(reset_cause::SOFTWARE),
        "brown-out" => Ok(reset_cause::BROWN_OUT),
        "unknown" => Ok(reset_cause::UNKNOWN),
        _ => Err(format!(
            "--reset-cause: {word} is not power-on, watchdog, software, brown-out or unknown"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Options, String> {
        Options::parse(line.split_whitespace().map(String::from), None)
    }

    #[test]
    fn the_serial_line_is_needed_and_the_rest_has_defaults() {
        assert_eq!(
            parse("--serial-fd 5"),
            Ok(Options {
                statistics: false,
                wire: WireKind::Serial,
                serial: 5,
                baud: DEFAULT_BAUD,
                git_hash: 0,
                parameters: None,
                reset_cause: reset_cause::POWER_ON,
            })
        );
        assert!(parse("").is_err());
        assert!(parse("--serial-fd 1").is_err());
        assert!(parse("--serial-fd 5 --wire radio").is_err());
        assert_eq!(
            parse("--wire can --serial-fd 5").unwrap().wire,
            WireKind::Can
        );
    }

    #[test]
    fn a_reset_has_a_cause() {
        let options = parse("--serial-fd 5 --reset-cause watchdog").unwrap();
        assert_eq!(options.reset_cause, reset_cause::WATCHDOG);
        assert!(parse("--serial-fd 5 --reset-cause lightning").is_err());
    }

    #[test]
    fn a_commit_is_cut_to_its_first_32_bits() {
        let options = parse("--serial-fd 5 --git-hash deadbeef0123 --baud 115200").unwrap();
        assert_eq!((options.git_hash, options.baud), (0xdead_beef, 115_200));
        assert!(parse("--serial-fd 5 --git-hash xyz").is_err());
    }
}
