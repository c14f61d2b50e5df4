//! Segments in the making: whole numbers, and the exact state and pose at their end.

use super::bend::{advance, drive, Curve, State};
use super::limits::Limits;

/// Duration in µs, jerks in millionths of the SI unit, 1 where a run begins, 1 where it ends at rest.
pub type Fields = [i64; 5];

/// Where a row was, to come back to.
#[derive(Clone, Copy)]
pub struct Mark {
    /// Segments before.
    pub segments: usize,
    /// Then.
    pub state: State,
    begin: bool,
}

/// A row of segments.
pub struct Row {
    /// Of each segment.
    pub fields: Vec<Fields>,
    /// At the end of the last.
    pub state: State,
    begin: bool,
}

impl Row {
    /// At rest.
    pub fn new(state: State) -> Self {
        Self {
            fields: vec![],
            state,
            begin: true,
        }
    }

    /// One more segment.
    pub fn add(&mut self, segment: [i64; 3]) {
        advance(&mut self.state, &segment);
        self.push(segment);
    }

    /// The segments of curves, one curve after the other.
    pub fn follow(&mut self, curves: impl Iterator<Item = Curve>, limits: &Limits) {
        for curve in curves {
            for segment in drive(&mut self.state, &curve, limits) {
                self.push(segment);
            }
        }
    }

    /// What was added last ends at rest; what comes next begins a run.
    pub fn rest(&mut self) {
        if let (Some(last), false) = (self.fields.last_mut(), self.begin) {
            last[4] = 1;
            self.state = State {
                x: self.state.x,
                y: self.state.y,
                heading: self.state.heading,
                ..State::default()
            };
            self.begin = true;
        }
    }

    /// Where it is now.
    pub fn mark(&self) -> Mark {
        Mark {
            segments: self.fields.len(),
            state: self.state,
            begin: self.begin,
        }
    }

    /// Forgets what was added after the mark.
    pub fn reset(&mut self, mark: &Mark) {
        self.fields.truncate(mark.segments);
        (self.state, self.begin) = (mark.state, mark.begin);
    }

    fn push(&mut self, [duration, travel, heading]: [i64; 3]) {
        let begin = i64::from(self.begin);
        self.fields.push([duration, travel, heading, begin, 0]);
        self.begin = false;
    }
}
