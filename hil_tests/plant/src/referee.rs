//! What really happened: contacts, clearance, and ground driven on before it was seen. Knows only the truth.

use crate::config::Config;
use crate::obstacle::{obstacle_clearance, wall_clearance, Obstacle};
use crate::pose::Pose;
use crate::survey::Survey;

/// Contact patch of a wheel: length along the rover, width across, metres.
const PATCH: (f64, f64) = (0.06, 0.025);
/// The ball caster behind the wheels: distance behind base_link, and radius of its contact, metres.
const CASTER: (f64, f64) = (0.10, 0.012);
/// A contact is over when there is this much room again, metres.
const RELEASE: f64 = 0.005;
/// A contact up to this closing speed is one that the bumper is made for; a harder one is a collision, m/s.
const HARD: f64 = 0.1;
/// Closer than this counts as touching: the plant keeps the two exactly apart while they press.
const TOUCH: f64 = 1e-4;

/// What has been counted and measured so far.
pub struct Referee {
    area: (f64, f64),
    radius: f64,
    half_track: f64,
    in_contact: bool,
    hard: bool,
    /// Contacts with obstacles and walls that were harder than HARD; one counts until there is room again.
    pub collisions: u32,
    /// The others, counted in the same way.
    pub bumper_contacts: u32,
    /// Smallest distance from the footprint to an obstacle, metres; infinite without obstacles.
    pub min_clearance: f64,
    /// Smallest distance from the footprint to a bound of the area, metres.
    pub min_wall_clearance: f64,
    /// (time s, x, y, heading) every 10 ms.
    pub truth: Vec<[f64; 4]>,
}

impl Referee {
    /// A referee that has seen nothing yet.
    pub fn new(config: &Config) -> Self {
        Self {
            area: (config.area_width, config.area_height),
            radius: config.footprint_radius,
            half_track: 0.5 * config.drive.track_width,
            in_contact: false,
            hard: false,
            collisions: 0,
            bumper_contacts: 0,
            min_clearance: f64::INFINITY,
            min_wall_clearance: f64::INFINITY,
            truth: Vec::new(),
        }
    }

    /// Looks at one moment; called every 10 ms. `struck`: the greatest closing speed at which the plant
    /// held the rover back since the last look, if it did.
    pub fn look(
        &mut self,
        now_us: u64,
        pose: Pose,
        struck: Option<f64>,
        obstacles: &[Obstacle],
        survey: &mut Survey,
    ) {
        self.truth
            .push([now_us as f64 * 1e-6, pose.x, pose.y, pose.heading]);
        let room = obstacle_clearance(pose, self.radius, obstacles);
        let walls = wall_clearance(pose, self.radius, self.area.0, self.area.1);
        self.min_clearance = self.min_clearance.min(room);
        self.min_wall_clearance = self.min_wall_clearance.min(walls);
        let nearest = room.min(walls);
        if struck.is_some() || nearest <= TOUCH {
            self.touch(struck.unwrap_or(0.0) > HARD);
        } else if nearest > RELEASE {
            self.in_contact = false;
        }
        self.touch_ground(pose, survey);
    }

    /// One more moment of a contact, or the first. A soft one that becomes hard is a collision.
    fn touch(&mut self, hard: bool) {
        if !self.in_contact {
            (self.in_contact, self.hard) = (true, false);
            self.bumper_contacts += 1;
        }
        if hard && !self.hard {
            self.hard = true;
            self.bumper_contacts -= 1;
            self.collisions += 1;
        }
    }

    fn touch_ground(&self, pose: Pose, survey: &mut Survey) {
        let (sine, cosine) = pose.heading.sin_cos();
        let (half_length, half_width) = (0.5 * PATCH.0, 0.5 * PATCH.1);
        let reach = half_length.hypot(half_width);
        for side in [self.half_track, -self.half_track] {
            let wheel = pose.compose(0.0, side, 0.0);
            survey.touch(
                [wheel.x - reach, wheel.y - reach],
                [wheel.x + reach, wheel.y + reach],
                |x, y| {
                    let (dx, dy) = (x - wheel.x, y - wheel.y);
                    let (along, across) = (cosine * dx + sine * dy, cosine * dy - sine * dx);
                    along.abs() <= half_length && across.abs() <= half_width
                },
            );
        }
        let (behind, ball) = CASTER;
        let caster = pose.compose(-behind, 0.0, 0.0);
        survey.touch(
            [caster.x - ball, caster.y - ball],
            [caster.x + ball, caster.y + ball],
            |x, y| (x - caster.x).hypot(y - caster.y) <= ball,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Scene {
        referee: Referee,
        survey: Survey,
        now_us: u64,
    }

    impl Scene {
        fn new() -> Self {
            let config = Config::default();
            Self {
                referee: Referee::new(&config),
                survey: Survey::new(&config),
                now_us: 0,
            }
        }

        fn look(&mut self, x: f64, struck: Option<f64>) {
            const POST: Obstacle = Obstacle {
                x: 1.5,
                y: 0.4,
                radius: 0.05,
                height: 0.3,
            };
            let pose = Pose {
                x,
                y: 0.4,
                heading: 0.0,
            };
            self.now_us += 10_000;
            self.referee
                .look(self.now_us, pose, struck, &[POST], &mut self.survey);
        }
    }

    #[test]
    fn one_contact_counts_once_until_there_is_room_again() {
        let mut scene = Scene::new();
        for (x, struck) in [
            (1.0, None),
            (1.3, Some(0.2)),
            (1.299, Some(0.3)),
            (1.298, None),
            (1.3, Some(0.2)),
        ] {
            scene.look(x, struck);
        }
        assert_eq!(
            scene.referee.collisions, 1,
            "2 mm of room are no end of a contact"
        );
        scene.look(1.2, None);
        scene.look(1.3, Some(0.2));
        assert_eq!(scene.referee.collisions, 2);
        assert_eq!(scene.referee.bumper_contacts, 0);
        assert!(scene.referee.min_clearance.abs() < 1e-9);
    }

    #[test]
    fn a_soft_contact_is_counted_apart_until_it_becomes_a_hard_one() {
        let mut scene = Scene::new();
        scene.look(1.3, Some(0.05));
        scene.look(1.3, Some(0.0));
        let counts = |scene: &Scene| (scene.referee.collisions, scene.referee.bumper_contacts);
        assert_eq!(counts(&scene), (0, 1));
        scene.look(1.3, Some(0.2));
        assert_eq!(counts(&scene), (1, 0), "it pushes on");
        scene.look(1.2, None);
        scene.look(1.3, Some(0.09));
        assert_eq!(counts(&scene), (1, 1));
    }

    #[test]
    fn wheels_and_caster_on_unseen_ground_are_counted() {
        let mut scene = Scene::new();
        scene.look(0.4, None);
        assert_eq!(
            scene.survey.unseen_touched(),
            0.0,
            "the launch disc was surveyed"
        );
        scene.look(2.0, None);
        let patches = 2.0 * PATCH.0 * PATCH.1 + std::f64::consts::PI * CASTER.1 * CASTER.1;
        assert!((scene.survey.unseen_touched() - patches).abs() < 0.3 * patches);
        assert_eq!(scene.referee.truth.last().unwrap()[..2], [0.02, 2.0]);
    }
}
