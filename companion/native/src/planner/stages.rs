//! Which parts of the planner ran, for how long.

use std::time::Instant;

/// One part of the planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// What ran, such as "tree" or "lattice".
    pub name: &'static str,
    /// Seconds by the clock.
    pub seconds: f64,
    /// Tree extensions, shortcut attempts, or cells that were expanded.
    pub iterations: u64,
}

/// The stages of one plan, in the order in which each first ran.
#[derive(Default)]
pub struct Stages {
    stages: Vec<Stage>,
    /// Nodes of trees and labelled cells of lattices.
    pub nodes: usize,
}

impl Stages {
    /// Adds what a stage has done since `began`.
    pub fn record(&mut self, name: &'static str, began: Instant, iterations: u64) {
        let seconds = began.elapsed().as_secs_f64();
        match self.stages.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => {
                stage.seconds += seconds;
                stage.iterations += iterations;
            }
            None => self.stages.push(Stage {
                name,
                seconds,
                iterations,
            }),
        }
    }

    /// True when this stage has run.
    pub fn ran(&self, name: &str) -> bool {
        self.stages.iter().any(|stage| stage.name == name)
    }

    /// Iterations of all stages.
    pub fn iterations(&self) -> u64 {
        self.stages.iter().map(|stage| stage.iterations).sum()
    }

    /// The list, in the order in which each stage first ran.
    pub fn into_list(self) -> Vec<Stage> {
        self.stages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_runs_twice_is_listed_once_with_its_iterations_added() {
        let mut stages = Stages::default();
        stages.record("tree", Instant::now(), 10);
        stages.record("lattice", Instant::now(), 5);
        stages.record("tree", Instant::now(), 3);
        assert_eq!(stages.iterations(), 18);
        assert!(stages.ran("lattice") && !stages.ran("refine"));
        let names: Vec<&str> = stages.into_list().iter().map(|stage| stage.name).collect();
        assert_eq!(names, ["tree", "lattice"]);
    }
}
