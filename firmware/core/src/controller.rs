//! The core itself: one object that owns every part, and the order of things within a tick.

use heapless::Deque;
use rover_protocol::messages::{crash_event_kind, fault_code, State as StateMessage};

use crate::battery::Battery;
use crate::bumper::Bumper;
use crate::crash::{CrashEvent, CrashRecord};
use crate::drive_check::{DriveCheck, Verdict};
use crate::faults::Faults;
use crate::indicator::indicate;
use crate::inertial::Inertial;
use crate::injection::Injection;
use crate::io::{reset_cause, Identity, Inputs, Outputs, Reboot};
use crate::link::{Link, OutgoingFrame, Wire, BEAT_US};
use crate::log::Log;
use crate::motion::{Motion, Progress, Reference};
use crate::odometry::Odometry;
use crate::parameters::Parameters;
use crate::segment_inbox::SegmentInbox;
use crate::settings::Settings;
use crate::sonar::Sonar;
use crate::storage::StorageOrder;
use crate::supervisor::{Action, Event, State, Supervisor};
use crate::telemetry::Schedule;
use crate::wheels::{wheel_references, Wheel, WheelReference};

/// Ticks before the first state that commands can change.
const BOOT_TICKS: u32 = 10;
/// A gap between two ticks beyond which the control loop cannot be trusted.
const LONGEST_GAP_US: u64 = 50_000;
/// After a stop the motors go off when the wheels are slower than this, or after the time below.
const STANDING_UM_S: i32 = 15_000;
const SETTLE_US: u64 = 300_000;
/// Ticks between two looks at what LED and buzzer should do.
const INDICATOR_STRIDE: u32 = 10;

/// Everything that the rover's firmware knows.
#[derive(Debug)]
pub struct Core {
    pub(crate) identity: Identity,
    pub(crate) parameters: Parameters,
    /// Worked out from the parameters; see [`Core::parameters_changed`].
    pub(crate) settings: Settings,
    pub(crate) link: Link,
    pub(crate) log: Log,
    pub(crate) schedule: Schedule,
    pub(crate) supervisor: Supervisor,
    pub(crate) faults: Faults,
    pub(crate) motion: Motion,
    pub(crate) inbox: SegmentInbox,
    pub(crate) odometry: Odometry,
    pub(crate) wheels: [Wheel; 2],
    /// What the wheels should do, and the motion that it was worked out from.
    references: [WheelReference; 2],
    split: Reference,
    pub(crate) drive_check: DriveCheck,
    pub(crate) sonar: Sonar,
    pub(crate) battery: Battery,
    /// In test mode.
    pub(crate) injection: Option<Injection>,
    /// The session of the last Hello, of whatever schema.
    pub(crate) greeter: Option<u16>,
    /// The companion that may arm: the session of the last Hello that was accepted.
    pub(crate) session: Option<u16>,
    /// The latest token seen.
    pub(crate) arm_token: u16,
    pub(crate) keep_alive: Option<u8>,
    /// When the dead-man was last fed.
    pub(crate) fed_us: u64,
    pub(crate) rejected: u16,
    /// The last segment that was complete and found no room.
    pub(crate) waiting: Option<u16>,
    pub(crate) emergency_input: bool,
    pub(crate) bumper: Bumper,
    pub(crate) inertial: Inertial,
    /// When State is due on a bus without a companion.
    pub(crate) beat_us: u64,
    /// An acknowledgement is owed to the companion.
    pub(crate) status_due: bool,
    pub(crate) reboot: Option<Reboot>,
    /// The board keeps parameters; a save or load that it has to carry out.
    pub(crate) has_storage: bool,
    pub(crate) storage_order: Option<StorageOrder>,
    pub(crate) now_us: u64,
    /// When the last tick really began.
    began_us: u64,
    ticks: u32,
    state_since_us: u64,
    /// When the jerk-limited stop's reference came to rest.
    still_since_us: Option<u64>,
    last_state: StateMessage,
    /// LED and buzzer.
    signs: (bool, bool),
    /// The last crash, and the piece of it that is told next.
    pub(crate) crash: Option<CrashRecord>,
    pub(crate) crash_told: Option<u8>,
    /// For the board to keep, see [`Core::take_event`].
    pub(crate) events: Deque<CrashEvent, 8>,
}

impl Core {
    /// A rover that was just switched on. The first tick is its moment zero.
    pub fn new(identity: Identity) -> Self {
        let mut faults = Faults::default();
        if identity.reset_cause == reset_cause::WATCHDOG {
            faults.raise(fault_code::WATCHDOG, 0);
        }
        let mut events = Deque::new();
        let _ = events.push_back(CrashEvent {
            time_ms: 0,
            kind: crash_event_kind::START,
            detail: u16::from(identity.reset_cause),
        });
        Self {
            crash: None,
            crash_told: None,
            events,
            identity,
            faults,
            settings: Settings::new(&Parameters::default()),
            parameters: Parameters::default(),
            link: Link::default(),
            log: Log::default(),
            schedule: Schedule::default(),
            supervisor: Supervisor::default(),
            motion: Motion::default(),
            inbox: SegmentInbox::default(),
            odometry: Odometry::default(),
            wheels: [Wheel::default(), Wheel::default()],
            references: Default::default(),
            split: Reference::default(),
            drive_check: DriveCheck::default(),
            sonar: Sonar::default(),
            battery: Battery::default(),
            injection: None,
            greeter: None,
            session: None,
            arm_token: 0,
            keep_alive: None,
            fed_us: 0,
            rejected: 0,
            waiting: None,
            emergency_input: false,
            bumper: Bumper::default(),
            inertial: Inertial::default(),
            beat_us: BEAT_US,
            status_due: false,
            reboot: None,
            has_storage: false,
            storage_order: None,
            now_us: 0,
            began_us: 0,
            ticks: 0,
            state_since_us: 0,
            still_since_us: None,
            last_state: StateMessage::default(),
            signs: (false, false),
        }
    }

    /// Bytes of the serial line, the last of which came in at `now_us`.
    pub fn receive(&mut self, bytes: &[u8], now_us: u64) {
        for byte in bytes {
            if let Some(frame) = self.link.push(*byte) {
                self.command(frame.identifier, frame.payload(), now_us, Wire::Serial);
            }
        }
    }

    /// A frame of the CAN bus that came in at `now_us`.
    pub fn receive_frame(&mut self, identifier: u16, payload: &[u8], now_us: u64) {
        self.link.count_bus_frame();
        self.command(identifier, payload, now_us, Wire::Can);
    }

    /// Fill `out` with bytes for the serial line; returns how many. Ask only for what the wire takes now: what
    /// waits here can still be overtaken by something urgent. Nothing while the companion is on the CAN bus.
    pub fn transmit(&mut self, out: &mut [u8]) -> usize {
        self.link.transmit(out)
    }

    /// The next frame for the CAN bus; take one only when the controller has room for it. None unless the last valid
    /// Hello came over the bus: a frame goes out once, here or by [`Core::transmit`]. A board with both wires asks both.
    pub fn transmit_frame(&mut self) -> Option<OutgoingFrame> {
        self.link.next_frame(Wire::Can)
    }

    /// The board's receive buffer ran over and lost bytes.
    pub fn note_receive_overflow(&mut self) {
        self.faults.count(fault_code::RECEIVE_OVERFLOW, 0);
    }

    /// A fault that only the board can see, [`fault_code`] with its detail: counted and reported, not active.
    pub fn note_fault(&mut self, code: u8, times: u16, detail: u32) {
        self.faults.count_many(code, times, detail);
    }

    /// Faulty frames that the CAN controller has seen since the last time.
    pub fn note_bus_errors(&mut self, count: u16) {
        self.link.count_bus_errors(count);
    }

    /// A line for the companion's log.
    pub fn log_line(&mut self, text: &'static str) {
        self.log.line(text);
    }

    /// A restart that was asked for and allowed. The board carries it out.
    pub fn take_reboot(&mut self) -> Option<Reboot> {
        self.reboot.take()
    }

    /// One millisecond.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        let gap_us = inputs.began_us.saturating_sub(self.began_us);
        self.began_us = self.began_us.max(inputs.began_us);
        self.now_us = self.now_us.max(inputs.now_us);
        self.link.set_time(self.now_us);
        self.ticks = self.ticks.saturating_add(1);
        if self.ticks == BOOT_TICKS {
            self.raise(Event::BootDone, 0);
            self.log.line("rover firmware ready");
        }
        if gap_us > LONGEST_GAP_US && self.ticks > 1 {
            self.raise(Event::Internal, 1);
        }
        let inputs = self.measurements(&self.settings.wiring.inputs(inputs));
        let (steps, sonar_trigger) = self.sense(&inputs);
        self.watch(&inputs);
        self.accept_segments();
        self.advance_motion();
        self.drive(steps);
        self.report();
        let driven = self.supervisor.is_powered();
        let standing = self.is_standing();
        let powered = driven || self.bumper.holds(self.now_us, standing);
        let [left, right] = &self.wheels;
        if self.ticks.is_multiple_of(INDICATOR_STRIDE) {
            self.signs = indicate(self.supervisor.state(), self.now_us, self.state_since_us);
        }
        let (led, buzzer) = self.signs;
        let outputs = self.withheld(Outputs {
            duty_left: if driven { left.duty() } else { 0 },
            duty_right: if driven { right.duty() } else { 0 },
            powered,
            sonar_trigger,
            led,
            buzzer,
        });
        self.settings.wiring.outputs(outputs)
    }

    /// Advance the reference to this tick and tell the supervisor what came of it.
    fn advance_motion(&mut self) {
        let progress = self.motion.advance(self.now_us);
        match (self.supervisor.state(), progress) {
            // A run may begin and end within one tick: then nothing was seen of it.
            (State::Armed, Progress::Running) => self.raise(Event::RunStarted, 0),
            (State::Armed | State::Moving, Progress::Underrun) => {
                self.raise(Event::RunStarted, 0);
                self.faults
                    .raise(fault_code::UNDERRUN, u32::from(self.motion.executing()));
                self.raise(Event::Underrun, 0);
            }
            (State::Moving, Progress::Idle) => self.raise(Event::RunEnded, 0),
            (State::Retiring | State::Stopping, Progress::Idle) => self.settle(),
            _ => {}
        }
    }

    /// No wheel turns.
    pub(crate) fn is_standing(&self) -> bool {
        self.wheels
            .iter()
            .all(|wheel| wheel.velocity_um_s().abs() < STANDING_UM_S)
    }

    /// The stop's reference stands; the motors go off when the wheels do.
    fn settle(&mut self) {
        let since_us = *self.still_since_us.get_or_insert(self.now_us);
        if self.is_standing() || self.now_us.saturating_sub(since_us) >= SETTLE_US {
            self.raise(Event::Stopped, 0);
        }
    }

    /// Wheel control, and whether the wheels follow it.
    fn drive(&mut self, steps: [i32; 2]) {
        if !self.supervisor.is_powered() {
            return;
        }
        if self.split != *self.motion.reference() {
            self.split_motion();
        }
        let gains = &self.settings.gains;
        let scale = gains.battery_scale(self.battery.voltage_mv());
        for (wheel, reference) in self.wheels.iter_mut().zip(&self.references) {
            wheel.control(reference, gains, scale);
        }
        let stall = &self.settings.stall;
        match self.drive_check.tick(steps, &self.wheels, stall) {
            Verdict::Good => {}
            Verdict::Stall(wheel) => {
                self.faults.raise(fault_code::STALL, u32::from(wheel));
                self.raise(Event::Stall, wheel);
            }
            Verdict::Encoder(wheel) => {
                self.faults.raise(fault_code::ENCODER_LEFT + (wheel & 1), 0);
                self.raise(Event::EncoderFault, wheel);
            }
        }
    }

    fn split_motion(&mut self) {
        self.split = *self.motion.reference();
        self.references = wheel_references(&self.split, &self.settings.half_track);
    }

    /// Put an event to the supervisor and carry out what its table says.
    pub(crate) fn raise(&mut self, event: Event, detail: u8) {
        let before = self.supervisor.state();
        if matches!(event, Event::EmergencyInput | Event::EmergencyCommand) {
            self.bumper.release();
        }
        match self.supervisor.handle(event, detail) {
            Action::Nothing => {}
            Action::Cut => {
                self.motion.cut();
                self.flush_inbox();
                self.wheels.iter_mut().for_each(Wheel::release);
            }
            Action::Brake => {
                self.motion.stop(&self.settings.motion);
                self.flush_inbox();
                self.still_since_us = None;
            }
            Action::PowerOn => self.power_on(),
        }
        if self.supervisor.state() != before {
            self.state_since_us = self.now_us;
        }
    }

    /// What was sent until now is not for what comes; the companion hears from where to count.
    fn flush_inbox(&mut self) {
        self.inbox.flush();
        self.status_due = true;
    }

    fn power_on(&mut self) {
        self.motion.cut();
        self.flush_inbox();
        self.split_motion();
        for (wheel, reference) in self.wheels.iter_mut().zip(&self.references) {
            wheel.reset(reference);
        }
        self.bumper.release();
        self.drive_check.reset();
        self.faults.armed();
        // Counters of the keep-alive are compared within one arming: a companion may have started anew before it.
        self.keep_alive = None;
        self.fed_us = self.now_us;
    }

    /// Telemetry of this tick; State at once when anything in it has changed.
    fn report(&mut self) {
        let state = self.state_message();
        if state != self.last_state {
            let before = core::mem::replace(&mut self.last_state, state);
            self.note_change(&before, &state);
            self.link.send_urgent(&state);
        }
        self.send_reports();
    }
}
