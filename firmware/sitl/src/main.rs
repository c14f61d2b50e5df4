//! `rover-sitl`: the very core that runs on the board, as a process whose time is what its caller says.

mod battery;
mod can_adapter;
mod can_bus;
mod can_frame;
mod inertial;
mod line;
mod options;
mod parameter_file;
mod serial;
mod slcan;
mod tick_pipe;
mod wire;

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::ExitCode;

use battery::Converter;
use inertial::Inertial;
use options::{Options, USAGE};
use parameter_file::ParameterFile;
use rover_core::{board, reset_cause, Core, Identity};
use rover_protocol::rig_tick::TickRequest;
use wire::Wire;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).peekable();
    if arguments.peek().is_some_and(|first| first == "--help") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    let options = match Options::parse(arguments, option_env!("ROVER_GIT_HASH")) {
        Ok(options) => options,
        Err(message) => {
            eprintln!("rover-sitl: {message}\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rover-sitl: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Tick until the requests end.
fn run(options: &Options) -> io::Result<()> {
    let mut storage = match &options.parameters {
        Some(path) => Some(ParameterFile::open(path).map_err(|error| named(path, &error))?),
        None => None,
    };
    let mut core = start(options, options.reset_cause, &mut storage);
    let mut wire = Wire::open(options);
    let mut converter = Converter::default();
    let mut inertial = Inertial::default();
    let (mut requests, mut replies) = (io::stdin().lock(), io::stdout().lock());
    let mut bytes = [0; TickRequest::SIZE];
    let mut last_us = 0;
    loop {
        match requests.read_exact(&mut bytes) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                if options.statistics {
                    eprintln!("rover-sitl: {}", wire.statistics(last_us));
                }
                return Ok(());
            }
            Err(error) => return Err(error),
        }
        let request = TickRequest::read(&bytes);
        let now_us = request.now_us;
        last_us = now_us;
        if !wire.receive(&mut core, request.host_bytes_due, now_us, &io::stdin()) {
            return Ok(());
        }
        let mut inputs = tick_pipe::inputs(&request);
        inputs.battery_mv = converter.measure(now_us, inputs.battery_mv);
        inputs.inertial = inertial.measure(&request);
        let outputs = core.tick(&inputs);
        if let Some(storage) = &mut storage {
            core.serve_storage(storage);
        }
        wire.transmit(&mut core, now_us);
        let reply = tick_pipe::reply(&outputs, wire.bytes_sent());
        match replies
            .write_all(&reply.write())
            .and_then(|()| replies.flush())
        {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
            result => result?,
        }
        if core.take_reboot().is_some() {
            // The bootloader has nothing to load here: both kinds of restart start the core anew.
            core = start(options, reset_cause::SOFTWARE, &mut storage);
            inertial = Inertial::default();
        }
    }
}

/// A core that has just been switched on.
fn start(options: &Options, reset_cause: u8, storage: &mut Option<ParameterFile>) -> Core {
    let mut core = Core::new(Identity {
        board: board::SITL,
        git_hash: options.git_hash,
        reset_cause,
    });
    if let Some(storage) = storage {
        core.attach_storage(storage);
    }
    core
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(
        error.kind(),
        format!("--parameters {}: {error}", path.display()),
    )
}
