//! Virtual time in cycles, and the alarms that Python peripherals set.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use pyo3::prelude::*;

use super::{CYCLE_NS, NEVER};

struct Entry {
    due: Cell<u64>,
    sequence: Cell<u64>,
    callback: Py<PyAny>,
}

/// Shared by clock, alarms and processor.
#[derive(Default)]
pub struct Time {
    now: Cell<u64>,
    sequence: Cell<u64>,
    scheduled: RefCell<Vec<Rc<Entry>>>,
    next: Cell<Option<u64>>,
}

impl Time {
    /// The present cycle.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// Moves the clock without looking at alarms.
    pub fn set(&self, cycle: u64) {
        self.now.set(cycle);
    }

    /// When the next alarm is due; [`NEVER`] without one.
    pub fn next_due(&self) -> u64 {
        self.next.get().unwrap_or(NEVER)
    }

    fn add(&self, entry: &Rc<Entry>, due: u64) {
        self.remove(entry);
        entry.due.set(due);
        // Alarms of the same cycle go off in the order in which they were set.
        entry.sequence.set(self.sequence.get());
        self.sequence.set(self.sequence.get() + 1);
        self.scheduled.borrow_mut().push(Rc::clone(entry));
        self.next.set(Some(self.next_due().min(due)));
    }

    fn remove(&self, entry: &Rc<Entry>) {
        let mut scheduled = self.scheduled.borrow_mut();
        if let Some(index) = scheduled.iter().position(|other| Rc::ptr_eq(other, entry)) {
            scheduled.swap_remove(index);
            self.next
                .set(scheduled.iter().map(|other| other.due.get()).min());
        }
    }

    fn contains(&self, entry: &Rc<Entry>) -> bool {
        self.scheduled
            .borrow()
            .iter()
            .any(|other| Rc::ptr_eq(other, entry))
    }

    /// Calls every alarm that is due by `cycle`, each with the clock at its own time, so that what it schedules
    /// next does not drift by the length of an instruction.
    pub fn fire(&self, py: Python<'_>, cycle: u64) -> PyResult<()> {
        while self.next_due() <= cycle {
            let first = self
                .scheduled
                .borrow()
                .iter()
                .min_by_key(|entry| (entry.due.get(), entry.sequence.get()))
                .map(Rc::clone);
            let Some(entry) = first else { break };
            self.remove(&entry);
            self.now.set(entry.due.get());
            entry.callback.call0(py)?;
        }
        self.now.set(cycle);
        Ok(())
    }
}

/// The clock of the emulated chip, as rp2040py's peripherals expect it.
#[pyclass(unsendable, frozen, module = "rover_plant")]
#[derive(Default)]
pub struct Clock {
    /// Shared with the alarms and the processor.
    pub time: Rc<Time>,
}

#[pymethods]
impl Clock {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    #[getter]
    fn cycles(&self) -> u64 {
        self.time.now()
    }

    #[getter]
    fn frequency(&self) -> f64 {
        1e9 / CYCLE_NS as f64
    }

    #[getter]
    fn nanos(&self) -> f64 {
        (self.time.now() * CYCLE_NS) as f64
    }

    #[getter]
    fn micros(&self) -> f64 {
        self.nanos() / 1e3
    }

    #[getter]
    fn nanos_to_next_alarm(&self) -> f64 {
        match self.time.next.get() {
            Some(due) => (due.saturating_sub(self.time.now()) * CYCLE_NS) as f64,
            None => 0.0,
        }
    }

    #[getter]
    fn has_scheduled_alarm(&self) -> bool {
        self.time.next.get().is_some()
    }

    fn create_alarm(&self, callback: Py<PyAny>) -> Alarm {
        let entry = Entry {
            due: Cell::new(0),
            sequence: Cell::new(0),
            callback,
        };
        Alarm {
            time: Rc::clone(&self.time),
            entry: Rc::new(entry),
        }
    }
}

/// One alarm of a [`Clock`]; setting it anew moves it.
#[pyclass(unsendable, frozen, module = "rover_plant")]
pub struct Alarm {
    time: Rc<Time>,
    entry: Rc<Entry>,
}

#[pymethods]
impl Alarm {
    /// Goes off `nanos` from now, rounded up to whole cycles.
    fn schedule(&self, nanos: f64) {
        let cycles = (nanos.max(0.0) / CYCLE_NS as f64).ceil() as u64;
        self.time.add(&self.entry, self.time.now() + cycles);
    }

    /// Goes off at that cycle, at once when it has passed.
    fn schedule_at(&self, cycle: u64) {
        self.time.add(&self.entry, cycle.max(self.time.now()));
    }

    fn cancel(&self) {
        self.time.remove(&self.entry);
    }

    #[getter]
    fn scheduled(&self) -> bool {
        self.time.contains(&self.entry)
    }
}
