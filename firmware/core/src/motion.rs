//! Executes runs of constant-jerk segments: a queue, and the exact evaluation of the running segment at any moment.
//!
//! A segment is integrated in whole milliseconds from its own beginning and its last fraction by the closed form, so
//! the state at its end depends on the segments alone, never on where the ticks of the control loop fall.

use heapless::Deque;

use crate::axis::{Axis, Limits};
use crate::stop::AxisStop;

/// Segments that may wait behind the running one.
pub const QUEUE: usize = 64;
const SHORTEST_US: u32 = 1000;
/// From one advance to the next, as a rule.
const TICK_US: u32 = 1000;
/// What may be left of velocity (um/s, urad/s) and acceleration at the end of a segment that claims to rest.
const REST_RESIDUE: [Limits; 2] = [
    Limits {
        velocity: 5_000,
        acceleration: 100_000,
    },
    Limits {
        velocity: 50_000,
        acceleration: 500_000,
    },
];

/// One constant-jerk piece of travel and heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    pub index: u16,
    pub duration_us: u32,
    /// um/s^3.
    pub jerk_travel: i64,
    /// urad/s^3.
    pub jerk_heading: i64,
    /// Starts from rest at a time of its own.
    pub begins: bool,
    /// Velocity and acceleration are exactly zero at its end.
    pub rests: bool,
}

impl Segment {
    pub fn new(index: u16, duration_us: u32, travel: i32, heading: i32, flags: u8) -> Self {
        Self {
            index,
            duration_us,
            jerk_travel: i64::from(travel),
            jerk_heading: i64::from(heading),
            begins: flags & 1 != 0,
            rests: flags & 2 != 0,
        }
    }
}

/// Why a segment was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// No room: it can be repeated later.
    QueueFull,
    TooShort,
    /// Goes on from a run that does not exist, or begins one inside another.
    NotContinuous,
    /// Starts before now or before the run ahead of it has ended.
    StartPassed,
    /// Would exceed the limits of velocity or acceleration.
    BeyondLimits,
    /// Claims to end at rest and does not.
    NotAtRest,
}

/// The commanded motion at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reference {
    pub travel: Axis,
    pub heading: Axis,
}

impl Reference {
    fn step(&mut self, segment: &Segment) {
        self.travel.step(segment.jerk_travel);
        self.heading.step(segment.jerk_heading);
    }

    fn partial(&mut self, segment: &Segment, us: u32) {
        self.travel.partial(segment.jerk_travel, us);
        self.heading.partial(segment.jerk_heading, us);
    }

    pub fn at_rest(&self) -> bool {
        self.travel.at_rest() && self.heading.at_rest()
    }

    fn rest(&mut self) {
        self.travel.rest();
        self.heading.rest();
    }
}

#[derive(Clone, Copy, Debug)]
struct Running {
    segment: Segment,
    start_us: u64,
    /// Whole milliseconds of it that `base` already holds.
    done_ms: u32,
    /// What is left of it after the last advance, if `now` is inside of it.
    left_us: u32,
}

/// What the queue ends with: the state from which the next segment would go on.
#[derive(Clone, Copy, Debug)]
struct Tail {
    end_us: u64,
    state: Reference,
    rests: bool,
}

/// What happened during an advance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nothing runs; perhaps a run waits for its start.
    Idle,
    Running,
    /// The queue ran empty while moving. The caller must order a stop.
    Underrun,
    Stopping,
}

/// Limits of both axes, and of the stop: travel first, then heading.
#[derive(Clone, Copy, Debug)]
pub struct MotionLimits {
    pub travel: Limits,
    pub heading: Limits,
    /// um/s^2 and um/s^3.
    pub stop_travel: (i64, i64),
    pub stop_heading: (i64, i64),
    /// um/s that a wheel reaches with full duty, by the feed-forward.
    pub wheel: i64,
    pub half_track_um: i64,
}

#[derive(Debug, Default)]
pub struct Motion {
    queue: Deque<(Segment, Option<u64>), QUEUE>,
    running: Option<Running>,
    /// State at the last whole millisecond of the running segment.
    base: Reference,
    /// State at the moment of the last advance.
    now: Reference,
    now_us: u64,
    tail: Option<Tail>,
    stop: Option<(AxisStop, AxisStop)>,
    executing: u16,
}

impl Motion {
    pub fn reference(&self) -> &Reference {
        &self.now
    }

    /// Segments waiting or running.
    pub fn queued(&self) -> usize {
        self.queue.len() + usize::from(self.running.is_some())
    }

    pub fn free_slots(&self) -> usize {
        QUEUE - self.queue.len()
    }

    /// Index of the segment that runs, or of the last that ran.
    pub fn executing(&self) -> u16 {
        self.executing
    }

    /// Append a segment; `start_us` is needed when it begins a run.
    pub fn accept(
        &mut self,
        segment: Segment,
        start_us: Option<u64>,
        limits: &MotionLimits,
    ) -> Result<(), Refusal> {
        if segment.duration_us < SHORTEST_US {
            return Err(Refusal::TooShort);
        }
        let (from, begin_us) = self.joins(&segment, start_us)?;
        let state = end_of(&segment, from, limits).ok_or(Refusal::BeyondLimits)?;
        let state = rest_of(&segment, state).ok_or(Refusal::NotAtRest)?;
        let start_us = segment.begins.then_some(begin_us);
        self.queue
            .push_back((segment, start_us))
            .map_err(|_| Refusal::QueueFull)?;
        self.tail = Some(Tail {
            end_us: begin_us.saturating_add(u64::from(segment.duration_us)),
            state,
            rests: segment.rests,
        });
        Ok(())
    }

    /// Advance the reference to `now_us`.
    pub fn advance(&mut self, now_us: u64) -> Progress {
        let passed_us = now_us.saturating_sub(self.now_us).min(100_000) as u32;
        self.now_us = now_us;
        if let Some((travel, heading)) = &mut self.stop {
            let still = travel.advance(&mut self.now.travel, passed_us);
            if heading.advance(&mut self.now.heading, passed_us) && still {
                self.stop = None;
                return Progress::Idle;
            }
            return Progress::Stopping;
        }
        if passed_us == TICK_US && self.step() {
            return Progress::Running;
        }
        loop {
            let Some(running) = self.running.or_else(|| self.next_run(now_us)) else {
                return Progress::Idle;
            };
            self.executing = running.segment.index;
            if let Some(after) = self.execute(running, now_us) {
                self.running = Some(after);
                return Progress::Running;
            }
            let end_us = running.start_us + u64::from(running.segment.duration_us);
            self.now = self.base;
            self.running = match self.queue.front() {
                Some((segment, None)) => Some(start(*segment, end_us)),
                Some((_, Some(_))) => None,
                None if self.now.at_rest() => None,
                None => {
                    self.running = None;
                    return Progress::Underrun;
                }
            };
            if self.running.is_some() {
                self.queue.pop_front();
            } else if self.queue.is_empty() {
                self.tail = None;
            }
        }
    }

    /// One whole tick within the running segment, which is nearly every tick: two polynomials in steps, no division.
    /// False when the segment ends before, and nothing has changed.
    fn step(&mut self) -> bool {
        match &mut self.running {
            Some(running) if running.left_us > TICK_US => {
                running.left_us -= TICK_US;
                running.done_ms += 1;
                self.base.step(&running.segment);
                self.now.step(&running.segment);
                true
            }
            _ => false,
        }
    }

    /// Drop everything queued and bring both axes to rest from where they are.
    pub fn stop(&mut self, limits: &MotionLimits) {
        self.flush();
        if self.stop.is_none() {
            let (a, j) = limits.stop_travel;
            let travel = AxisStop::plan(&self.now.travel, a, j);
            let (a, j) = limits.stop_heading;
            self.stop = Some((travel, AxisStop::plan(&self.now.heading, a, j)));
        }
    }

    /// Drop everything; the reference stands still at once.
    pub fn cut(&mut self) {
        self.flush();
        self.stop = None;
        self.now.rest();
    }

    fn flush(&mut self) {
        self.queue.clear();
        self.running = None;
        self.tail = None;
        self.base = self.now;
    }

    /// The state and the time at which the segment takes over from the queue's end.
    fn joins(&self, segment: &Segment, start_us: Option<u64>) -> Result<(Reference, u64), Refusal> {
        match (segment.begins, self.tail) {
            (false, None) => Err(Refusal::NotContinuous),
            (false, Some(tail)) => Ok((tail.state, tail.end_us)),
            (true, Some(tail)) if !tail.rests => Err(Refusal::NotContinuous),
            (true, tail) => {
                let start_us = start_us.ok_or(Refusal::NotContinuous)?;
                let earliest_us = tail.map_or(0, |tail| tail.end_us).max(self.now_us);
                if start_us < earliest_us {
                    return Err(Refusal::StartPassed);
                }
                Ok((Reference::default(), start_us))
            }
        }
    }

    /// Take the next run from the queue once its start time has come.
    fn next_run(&mut self, now_us: u64) -> Option<Running> {
        let (segment, start_us) = *self.queue.front()?;
        let start_us = start_us?;
        if now_us < start_us {
            return None;
        }
        self.queue.pop_front();
        self.base = self.now;
        Some(start(segment, start_us))
    }

    /// Bring `base` and `now` to `now_us`; None when the segment has ended, with its end state in `base`.
    fn execute(&mut self, mut running: Running, now_us: u64) -> Option<Running> {
        let segment = running.segment;
        let elapsed_us = now_us.saturating_sub(running.start_us);
        let until_us = elapsed_us.min(u64::from(segment.duration_us)) as u32;
        while running.done_ms < until_us / 1000 {
            self.base.step(&segment);
            running.done_ms += 1;
        }
        if elapsed_us < u64::from(segment.duration_us) {
            running.left_us = segment.duration_us.saturating_sub(until_us);
            self.now = self.base;
            self.now.partial(&segment, until_us % 1000);
            return Some(running);
        }
        self.base.partial(&segment, segment.duration_us % 1000);
        if segment.rests {
            self.base.rest();
        }
        None
    }
}

fn start(segment: Segment, start_us: u64) -> Running {
    Running {
        segment,
        start_us,
        done_ms: 0,
        left_us: 0,
    }
}

/// Velocity and acceleration at the end of a segment, None if it breaks a limit on the way.
fn end_of(segment: &Segment, mut state: Reference, limits: &MotionLimits) -> Option<Reference> {
    let ticks = i64::from(segment.duration_us / 1000);
    let held = limits
        .travel
        .hold(&state.travel, segment.jerk_travel, ticks)
        && limits
            .heading
            .hold(&state.heading, segment.jerk_heading, ticks)
        && wheels_hold(segment, &state, limits, ticks);
    if !held {
        return None;
    }
    state.travel.velocity_after(segment.jerk_travel, ticks);
    state.heading.velocity_after(segment.jerk_heading, ticks);
    state.partial(segment, segment.duration_us % 1000);
    Some(state)
}

/// Each axis may be within its limits and a wheel still have to turn faster than its motor can.
fn wheels_hold(segment: &Segment, from: &Reference, limits: &MotionLimits, ticks: i64) -> bool {
    let wheel = Limits::of_velocity(limits.wheel);
    [limits.half_track_um, -limits.half_track_um]
        .iter()
        .all(|half_um| {
            let axis = Axis::of_wheel(&from.travel, &from.heading, *half_um);
            let jerk = segment.jerk_travel + segment.jerk_heading * half_um / 1_000_000;
            wheel.hold(&axis, jerk, ticks)
        })
}

/// A segment that rests ends with exactly zero; None if that would be a jump.
fn rest_of(segment: &Segment, mut state: Reference) -> Option<Reference> {
    if segment.rests {
        let [travel, heading] = REST_RESIDUE;
        if !travel.allow(&state.travel) || !heading.allow(&state.heading) {
            return None;
        }
        state.rest();
    }
    Some(state)
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
