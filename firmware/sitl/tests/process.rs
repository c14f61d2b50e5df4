//! The process as its callers see it: ticks over pipes, the serial line over a socket pair, virtual time.

use std::ffi::OsStr;
use std::io::{Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use rover_protocol::framing::{encode_message, Decoder, Frame, MAX_FRAME};
use rover_protocol::messages as m;
use rover_protocol::rig_tick::TickRequest;
use rover_protocol::Message;

struct Rig {
    child: Child,
    requests: Option<ChildStdin>,
    replies: ChildStdout,
    line: Option<UnixStream>,
    decoder: Decoder,
    now_us: u64,
    host_bytes: u64,
    sequence: u8,
}

struct Reply {
    flags: u8,
    sent: u64,
}

impl Rig {
    fn start() -> Self {
        Self::start_with(&[])
    }

    fn start_with(options: &[&OsStr]) -> Self {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let descriptor = theirs.as_raw_fd();
        let mut command = Command::new(env!("CARGO_BIN_EXE_rover-sitl"));
        command
            .args(["--serial-fd", &descriptor.to_string()])
            .args(["--git-hash", "0123456789abcdef"])
            .args(options)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        // SAFETY: between fork and exec only fcntl is called, which is async-signal-safe.
        unsafe {
            command.pre_exec(move || {
                let fd = rustix::fd::BorrowedFd::borrow_raw(descriptor);
                Ok(rustix::io::fcntl_setfd(fd, rustix::io::FdFlags::empty())?)
            });
        }
        let mut child = command.spawn().unwrap();
        ours.set_nonblocking(true).unwrap();
        Self {
            requests: child.stdin.take(),
            replies: child.stdout.take().unwrap(),
            child,
            line: Some(ours),
            decoder: Decoder::new(),
            now_us: 0,
            host_bytes: 0,
            sequence: 0,
        }
    }

    fn send<M: Message>(&mut self, message: &M) {
        let mut wire = [0; MAX_FRAME];
        let length = encode_message(message, self.sequence, &mut wire);
        self.sequence = self.sequence.wrapping_add(1);
        self.line
            .as_mut()
            .unwrap()
            .write_all(&wire[..length])
            .unwrap();
        self.host_bytes += length as u64;
    }

    fn tick(&mut self) -> Reply {
        self.now_us += 1000;
        let mut request = [0; TickRequest::SIZE];
        request[0..8].copy_from_slice(&self.now_us.to_le_bytes());
        request[20..22].copy_from_slice(&7400_u16.to_le_bytes());
        request[22] = 255;
        request[24..32].copy_from_slice(&self.host_bytes.to_le_bytes());
        self.requests.as_mut().unwrap().write_all(&request).unwrap();
        let mut reply = [0; 16];
        self.replies.read_exact(&mut reply).unwrap();
        Reply {
            flags: reply[4],
            sent: u64::from_le_bytes(reply[8..16].try_into().unwrap()),
        }
    }

    fn frames(&mut self) -> Vec<Frame> {
        let mut bytes = vec![0; 65_536];
        let count = self.line.as_mut().unwrap().read(&mut bytes).unwrap_or(0);
        bytes[..count]
            .iter()
            .filter_map(|byte| self.decoder.push(*byte))
            .collect()
    }

    fn find<M: Message>(frames: &[Frame]) -> Option<M> {
        frames
            .iter()
            .rev()
            .find(|frame| frame.identifier == M::ID)
            .and_then(|frame| M::read(frame.payload()))
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.requests = None;
        let _ = self.child.wait();
    }
}

#[test]
fn answers_the_handshake_arms_and_stops_by_its_dead_man_when_the_line_goes_dead() {
    let mut rig = Rig::start();
    for _ in 0..20 {
        rig.tick();
    }
    rig.send(&m::Hello {
        schema_hash: m::SCHEMA_HASH,
        session: 77,
    });
    rig.send(&m::Arm {
        token: 1,
        session: 77,
    });
    for _ in 0..20 {
        rig.tick();
    }
    let frames = rig.frames();
    let reply: m::HelloReply = Rig::find(&frames).unwrap();
    assert_eq!(reply.schema_hash, m::SCHEMA_HASH);
    let build: m::HelloBuild = Rig::find(&frames).unwrap();
    assert_eq!((build.accepted, build.session), (1, 77));
    assert_eq!(build.git_hash, 0x0123_4567);
    let state: m::State = Rig::find(&frames).unwrap();
    assert_eq!(state.state, m::state_state::ARMED);
    assert_eq!(rig.tick().flags & 1, 1, "powered");

    rig.line = None;
    let mut powered_ms = 0;
    while rig.tick().flags & 1 != 0 {
        powered_ms += 1;
        assert!(powered_ms < 400);
    }
    assert!(powered_ms > 250);
}

#[test]
fn sends_no_faster_than_the_baud_rate() {
    let mut rig = Rig::start();
    rig.send(&m::TelemetryRate {
        message: m::WheelTicks::ID,
        period: 5,
    });
    rig.send(&m::TelemetryRate {
        message: m::Velocity::ID,
        period: 5,
    });
    let mut before = 0;
    for _ in 0..500 {
        let reply = rig.tick();
        assert!(
            reply.sent - before <= 24,
            "230400 baud are 23.04 bytes a ms"
        );
        before = reply.sent;
        rig.frames();
    }
    assert!(before > 4_000);
}

#[test]
fn ticks_fast_enough_that_the_firmware_is_not_what_a_simulation_waits_for() {
    let mut rig = Rig::start();
    let start = Instant::now();
    for _ in 0..5_000 {
        rig.tick();
    }
    let rate = 5_000.0 / start.elapsed().as_secs_f64();
    println!("{rate:.0} ticks/s");
    // A debug build on a busy machine still leaves several times real time.
    assert!(rate > 5_000.0, "{rate:.0} ticks/s");
}

#[test]
fn ends_when_its_requests_end() {
    let mut rig = Rig::start();
    rig.tick();
    rig.requests = None;
    assert!(rig.child.wait().unwrap().success());
}

#[test]
fn saved_parameters_are_in_the_file_for_the_next_process() {
    let folder = std::env::temp_dir().join(format!("rover-sitl-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("parameters");
    let options = [OsStr::new("--parameters"), file.as_os_str()];
    let ask = |rig: &mut Rig| {
        rig.send(&m::ParameterGet { identifier: 1 });
        for _ in 0..20 {
            rig.tick();
        }
        Rig::find::<m::ParameterValue>(&rig.frames()).unwrap().value
    };
    let mut rig = Rig::start_with(&options);
    assert_eq!(ask(&mut rig), 300);
    rig.send(&m::ParameterSet {
        identifier: 1,
        value: 400,
    });
    rig.send(&m::ParameterCommand {
        command: m::parameter_command_command::SAVE,
    });
    for _ in 0..20 {
        rig.tick();
    }
    rig.frames();
    assert_eq!(ask(&mut rig), 400);
    drop(rig);
    assert_eq!(ask(&mut Rig::start_with(&options)), 400);
    std::fs::remove_dir_all(&folder).unwrap();
}
