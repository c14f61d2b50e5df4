//! What Python sees: this file only converts between Python and the simulated world.

use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyConnectionError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::attitude::Stance;
use crate::camera::Frame;
use crate::chip::{Alarm, Clock, Processor};
use crate::config::Config;
use crate::drive::Bridge;
use crate::obstacle::Obstacle;
use crate::pose::Pose;
use crate::sitl::Sitl;
use crate::survey::CELL;
use crate::terrain::Terrain;
use crate::world::World;

type FrameTuple<'py> = (u64, u64, u64, bool, Bound<'py, PyBytes>);

/// The rover and its field. `config_json`: see config.rs; rasters float32 (rows, columns), kelvin and metres;
/// obstacles float64 (n, 4): x, y, radius, height. Raises ValueError for a bad configuration.
#[pyclass]
pub struct Plant {
    world: World,
}

#[pymethods]
impl Plant {
    #[new]
    fn new(
        config_json: &str,
        temperature: PyReadonlyArray2<'_, f32>,
        height: PyReadonlyArray2<'_, f32>,
        obstacles: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Self> {
        let config = Config::parse(config_json).map_err(PyValueError::new_err)?;
        if temperature.shape() != height.shape() {
            return Err(PyValueError::new_err(
                "temperature and height must have the same shape",
            ));
        }
        if obstacles.shape()[1] != 4 {
            return Err(PyValueError::new_err(
                "obstacles must have four columns: x, y, radius, height",
            ));
        }
        let columns = height.shape()[1];
        let origin = (config.raster_origin_x, config.raster_origin_y);
        let rasters = (
            temperature.as_array().iter().copied().collect(),
            height.as_array().iter().copied().collect(),
        );
        let terrain = Terrain::new(
            rasters.0,
            rasters.1,
            columns,
            origin,
            config.raster_resolution,
        )
        .map_err(PyValueError::new_err)?;
        let obstacles = obstacles
            .as_array()
            .rows()
            .into_iter()
            .map(|row| Obstacle {
                x: row[0],
                y: row[1],
                radius: row[2],
                height: row[3],
            })
            .collect();
        Ok(Self {
            world: World::new(config, terrain, obstacles),
        })
    }

    /// Lets a part of the ground's temperature change: kelvin by cell, times `series` by second. Raises ValueError.
    fn add_layer(
        &mut self,
        raster: PyReadonlyArray2<'_, f32>,
        series: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<()> {
        let raster = raster.as_array().iter().copied().collect();
        let series = series.as_array().to_vec();
        self.world
            .terrain
            .add_layer(raster, series)
            .map_err(PyValueError::new_err)
    }

    /// Puts a rover-sitl that has just been started into the loop: descriptors of its stdin (write end) and stdout
    /// (read end), and how many bytes the host had written by then; those on the wire are lost to it.
    #[pyo3(signature = (stdin_fd, stdout_fd, host_bytes = 0))]
    fn attach_sitl(&mut self, stdin_fd: i32, stdout_fd: i32, host_bytes: u64) -> PyResult<()> {
        self.world
            .attach(Sitl::attach(stdin_fd, stdout_fd)?, host_bytes);
        Ok(())
    }

    /// Lets go of rover-sitl, so that it sees the end of its stdin.
    fn detach_sitl(&mut self) {
        self.world.detach();
    }

    /// Keeps every tick's request and reply from here on, for `take_ticks`.
    fn record_ticks(&mut self) {
        self.world.record_ticks();
    }

    /// Requests (56 bytes) and replies (16) of the ticks since the last call, tick by tick; empty when not recorded.
    fn take_ticks<'py>(&mut self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.world.take_ticks())
    }

    /// Physics and firmware up to `until_us`; `host_bytes`: total that the host has written up to the present.
    /// Returns [(time_us, total bytes of the firmware)] where the total changed. Raises ConnectionError when
    /// rover-sitl has ended.
    fn run_until(
        &mut self,
        py: Python<'_>,
        until_us: u64,
        host_bytes: u64,
    ) -> PyResult<Vec<(u64, u64)>> {
        let world = &mut self.world;
        py.detach(|| world.run_until(until_us, host_bytes))
            .map_err(|error| PyConnectionError::new_err(error.to_string()))
    }

    /// One millisecond of physics with duties -1..1, for rigs that bring their own firmware.
    fn step(&mut self, duty_left: f64, duty_right: f64, powered: bool) {
        self.world.bridge = Bridge {
            duty: [duty_left, duty_right],
            powered,
        };
        self.world.step();
    }

    #[getter]
    fn now_us(&self) -> u64 {
        self.world.now_us
    }

    /// True pose: x, y (m), heading (rad, unwrapped).
    fn pose(&self) -> (f64, f64, f64) {
        let pose = self.world.pose;
        (pose.x, pose.y, pose.heading)
    }

    /// How the rover leans: roll (left side up) and pitch (nose down), rad.
    fn attitude(&self) -> (f64, f64) {
        let attitude = self.world.stance().attitude;
        (attitude.roll, attitude.pitch)
    }

    /// x4 quadrature counts (left, right).
    fn encoders(&self) -> (i32, i32) {
        self.world.drive.counts().into()
    }

    /// Wheel angles in radians since the start (left, right).
    fn wheel_angles(&self) -> (f64, f64) {
        self.world.drive.angle().into()
    }

    /// Wheel surface speeds in m/s (left, right).
    fn wheel_speeds(&self) -> (f64, f64) {
        self.world.drive.surface_speed().into()
    }

    /// Slip fractions of this moment (left, right).
    fn slip(&self) -> (f64, f64) {
        self.world.drive.slip().into()
    }

    /// Duties (left, right) and whether the bridges are powered, as commanded last.
    fn duty(&self) -> (f64, f64, bool) {
        let bridge = self.world.bridge;
        (bridge.duty[0], bridge.duty[1], bridge.powered)
    }

    /// Terminal voltage in V, and state of charge 0 to 1.
    fn battery(&self) -> (f64, f64) {
        (self.world.battery.voltage(), self.world.battery.charge())
    }

    fn set_charge(&mut self, charge: f64) {
        self.world.battery.set_charge(charge);
    }

    fn set_emergency_stop(&mut self, active: bool) {
        self.world.emergency_stop = active;
    }

    /// Puts a fault in or, with value 0, takes it away; names and values: src/faults.rs. Raises ValueError.
    fn set_fault(&mut self, name: &str, index: usize, value: f64) -> PyResult<()> {
        self.world
            .faults
            .set(name, index, value)
            .map_err(PyValueError::new_err)
    }

    /// Makes the encoder of wheel 0 or 1 jump by some counts.
    fn kick_encoder(&mut self, wheel: usize, counts: i32) -> PyResult<()> {
        if wheel > 1 {
            return Err(PyValueError::new_err(format!(
                "wheel {wheel}: there are two, 0 and 1"
            )));
        }
        self.world.drive.kick_encoder(wheel, counts);
        Ok(())
    }

    /// Sets the rover where a former run has left it, on ground that was seen then. Raises ValueError.
    fn drive_on(
        &mut self,
        seen: PyReadonlyArray2<'_, bool>,
        x: f64,
        y: f64,
        heading: f64,
    ) -> PyResult<()> {
        if self
            .world
            .drive_on(seen.as_slice()?, Pose { x, y, heading })
        {
            return Ok(());
        }
        Err(PyValueError::new_err(
            "the ground that was seen is of another area",
        ))
    }

    /// Somebody lifts the rover and sets it down elsewhere, as seen from base_link: metres and radians.
    fn carry(&mut self, ahead: f64, left: f64, turn: f64) {
        self.world.pose = self.world.pose.compose(ahead, left, turn);
    }

    /// Something that was not there before: an upright disc, metres.
    fn add_obstacle(&mut self, x: f64, y: f64, radius: f64, height: f64) {
        self.world.obstacles.push(Obstacle {
            x,
            y,
            radius,
            height,
        });
    }

    /// Lamp and buzzer of the rover.
    fn signals(&self) -> (bool, bool) {
        (self.world.led, self.world.buzzer)
    }

    /// Starts a ranging of sensor 0 to 2.
    fn trigger_sonar(&mut self, sensor: u8) {
        self.world.trigger_sonar(sensor);
    }

    /// (sensor, echo_us) that is back by now, 0 µs for a timeout; None when none is.
    fn poll_echo(&mut self) -> Option<(u8, u32)> {
        self.world
            .poll_echo()
            .map(|echo| (echo.sensor, echo.echo_us))
    }

    /// True range of a sonar in metres from a pose, None when nothing is in its cone.
    fn sonar_range(&self, sensor: usize, x: f64, y: f64, heading: f64) -> PyResult<Option<f64>> {
        if sensor > 2 {
            return Err(PyValueError::new_err(format!(
                "sonar {sensor}: there are three, 0 to 2"
            )));
        }
        Ok(self
            .world
            .sonar
            .true_range(sensor, Pose { x, y, heading }, &self.world.obstacles))
    }

    /// Frames delivered since the last call: (sequence, exposure_us, delivered_us, ffc, uint16 LE kelvin × 100).
    fn take_frames<'py>(&mut self, py: Python<'py>) -> Vec<FrameTuple<'py>> {
        let frames = std::mem::take(&mut self.world.delivered);
        let convert = |frame: Frame| {
            let bytes: Vec<u8> = frame
                .counts
                .iter()
                .flat_map(|count| count.to_le_bytes())
                .collect();
            (
                frame.sequence,
                frame.exposure_us,
                frame.delivered_us,
                frame.ffc,
                PyBytes::new(py, &bytes),
            )
        };
        frames.into_iter().map(convert).collect()
    }

    /// What a perfect sensor sees from a pose: kelvin, float32 (pixels,), row-major.
    fn scene<'py>(
        &self,
        py: Python<'py>,
        x: f64,
        y: f64,
        heading: f64,
    ) -> Bound<'py, PyArray1<f32>> {
        let world = &self.world;
        PyArray1::from_vec(
            py,
            py.detach(|| {
                world
                    .camera
                    .scene(Stance::level(Pose { x, y, heading }), &world.terrain)
                    .0
            }),
        )
    }

    /// True trajectory, float64 (n, 4): time s, x, y, heading; every 10 ms.
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let truth = &self.world.referee.truth;
        PyArray1::from_vec(py, truth.iter().flatten().copied().collect()).reshape([truth.len(), 4])
    }

    /// Ground seen so far: bool (rows, columns), with x and y of its lower-left corner and the cell's side in m.
    fn seen<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<bool>>, f64, f64, f64)> {
        let (columns, rows, x, y) = self.world.survey.shape();
        let raster = PyArray1::from_slice(py, self.world.survey.seen()).reshape([rows, columns])?;
        Ok((raster, x, y, CELL))
    }

    /// The referee's counts. A clearance is None when there is nothing to keep clear of.
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (referee, survey) = (&self.world.referee, &self.world.survey);
        let finite = |value: f64| value.is_finite().then_some(value);
        let verdict = PyDict::new(py);
        verdict.set_item("collisions", referee.collisions)?;
        verdict.set_item("bumper_contacts", referee.bumper_contacts)?;
        verdict.set_item("min_clearance_m", finite(referee.min_clearance))?;
        verdict.set_item("min_wall_clearance_m", finite(referee.min_wall_clearance))?;
        verdict.set_item("unseen_ground_m2", survey.unseen_touched())?;
        verdict.set_item("seen_share", survey.seen_share())?;
        Ok(verdict)
    }
}

#[pymodule]
fn rover_plant(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Plant>()?;
    module.add_class::<Clock>()?;
    module.add_class::<Alarm>()?;
    module.add_class::<Processor>()
}
