//! LED and buzzer: what the rover is doing, to someone who stands beside it.

use crate::supervisor::State;

/// LED and buzzer at `now_us`, when the state has lasted for `since_us`.
pub fn indicate(state: State, now_us: u64, since_us: u64) -> (bool, bool) {
    let blink = |period_ms: u64, on_ms: u64| (now_us / 1000) % period_ms < on_ms;
    let led = match state {
        State::Boot => false,
        State::Disarmed => blink(2_000, 100),
        State::Armed => true,
        State::Moving => blink(400, 200),
        State::Retiring | State::Stopping => blink(200, 100),
        State::Latched => blink(1_000, 500),
    };
    // A chirp on arming, three beeps on a latch.
    let lasted_ms = now_us.saturating_sub(since_us) / 1000;
    let buzzer = match state {
        State::Armed => lasted_ms < 60,
        State::Latched => lasted_ms < 900 && lasted_ms % 300 < 150,
        _ => false,
    };
    (led, buzzer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latch_beeps_three_times_and_then_keeps_quiet() {
        let beeps = |from: u64, to: u64| {
            let sound: Vec<bool> = (from..to)
                .map(|ms| indicate(State::Latched, ms * 1000, 0).1)
                .collect();
            sound.windows(2).filter(|pair| !pair[1] && pair[0]).count()
        };
        assert_eq!(beeps(0, 1_000), 3);
        assert_eq!(beeps(1_000, 5_000), 0);
    }
}
