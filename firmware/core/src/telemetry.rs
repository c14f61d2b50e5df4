//! When each telemetry message is due. Its content is built in `reports`.

use rover_protocol::messages as m;
use rover_protocol::Message;

/// Shortest period that may be asked for.
const SHORTEST_MS: u16 = 5;
#[derive(Clone, Copy, Debug)]
struct Entry {
    identifier: u16,
    period_ms: u16,
    due_us: u64,
}

const fn entry(identifier: u16, period_ms: u16, phase_ms: u64) -> Entry {
    Entry {
        identifier,
        period_ms,
        due_us: phase_ms * 1000,
    }
}

pub const MESSAGES: usize = 12;

/// Periods of all telemetry. Phases spread the load; both halves of the odometry share one, as they share their time.
#[derive(Clone, Debug)]
pub struct Schedule {
    entries: [Entry; MESSAGES],
    /// The earliest of all, or earlier.
    next_us: u64,
    sonar: bool,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            entries: [
                entry(m::State::ID, 100, 12),
                entry(m::MotionStatus::ID, 50, 14),
                entry(m::WheelTicks::ID, 20, 16),
                entry(m::OdometryPosition::ID, 50, 18),
                entry(m::OdometryHeading::ID, 50, 18),
                entry(m::Velocity::ID, 50, 22),
                entry(m::ReferenceDistance::ID, 50, 24),
                entry(m::Battery::ID, 500, 30),
                entry(m::MotorDuty::ID, 100, 32),
                entry(m::LinkStatistics::ID, 1000, 34),
                // Just before the wheels', so that turns of both are of nearly the same time.
                entry(m::InertialHeading::ID, 20, 15),
                entry(m::Gravity::ID, 20, 26),
            ],
            next_us: 0,
            sonar: true,
        }
    }
}

impl Schedule {
    /// Set the period of a message; 0 switches it off. False when it is no telemetry of ours.
    pub fn set(&mut self, identifier: u16, period_ms: u16, now_us: u64) -> bool {
        if identifier == m::Sonar::ID {
            self.sonar = period_ms != 0;
            return true;
        }
        match self.entry(identifier) {
            Some(entry) => {
                entry.period_ms = match period_ms {
                    0 => 0,
                    period => period.max(SHORTEST_MS),
                };
                entry.due_us = now_us;
                self.next_us = self.next_us.min(now_us);
                true
            }
            None => false,
        }
    }

    pub fn sonar_wanted(&self) -> bool {
        self.sonar
    }

    /// Whether anything may be due; false nearly always.
    pub fn is_due(&self, now_us: u64) -> bool {
        now_us >= self.next_us
    }

    /// Everything that is due has been taken.
    pub fn look_ahead(&mut self) {
        self.next_us = self
            .entries
            .iter()
            .filter(|entry| entry.period_ms != 0)
            .fold(u64::MAX, |next, entry| next.min(entry.due_us));
    }

    /// Identifier of the message in this place of the table if it is due now; it counts as sent.
    pub fn take_due(&mut self, place: usize, now_us: u64) -> Option<u16> {
        let entry = self.entries.get_mut(place)?;
        if entry.period_ms == 0 || now_us < entry.due_us {
            return None;
        }
        let period_us = u64::from(entry.period_ms) * 1000;
        entry.due_us = entry.due_us.saturating_add(period_us);
        if entry.due_us <= now_us {
            // Later than a period: on the grid still, and what was missed is not made up for.
            let late = now_us.saturating_sub(entry.due_us);
            let periods = late.checked_div(period_us).unwrap_or(0).saturating_add(1);
            entry.due_us = entry
                .due_us
                .saturating_add(periods.saturating_mul(period_us));
        }
        Some(entry.identifier)
    }

    fn entry(&mut self, identifier: u16) -> Option<&mut Entry> {
        self.entries
            .iter_mut()
            .find(|entry| entry.identifier == identifier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent_in_a_second(schedule: &mut Schedule, identifier: u16) -> usize {
        (0..1000)
            .flat_map(|ms| (0..MESSAGES).map(move |place| (ms, place)))
            .filter_map(|(ms, place)| schedule.take_due(place, ms * 1000))
            .filter(|sent| *sent == identifier)
            .count()
    }

    #[test]
    fn defaults_give_fifty_wheel_ticks_and_ten_states_a_second() {
        for (identifier, count) in [
            (m::WheelTicks::ID, 50),
            (m::State::ID, 10),
            (m::OdometryHeading::ID, 20),
            (m::Battery::ID, 2),
            (m::LinkStatistics::ID, 1),
        ] {
            let sent = sent_in_a_second(&mut Schedule::default(), identifier);
            assert_eq!(sent, count, "{identifier}");
        }
    }

    #[test]
    fn a_period_can_be_changed_and_switched_off_but_not_below_five_milliseconds() {
        let mut schedule = Schedule::default();
        assert!(schedule.set(m::Velocity::ID, 1, 0));
        assert_eq!(sent_in_a_second(&mut schedule, m::Velocity::ID), 200);
        let mut schedule = Schedule::default();
        assert!(schedule.set(m::State::ID, 0, 0));
        assert_eq!(sent_in_a_second(&mut schedule, m::State::ID), 0);
        assert!(!schedule.set(m::Hello::ID, 10, 0));
    }
}
