//! A sonar: a cone of sound, the nearest echo that is strong enough, and all that goes wrong.
//!
//! What is in sight within the cone is known exactly, however thin it is. Each surface has an echo
//! from its nearest visible point, and from where one of the rays that fan out over the cone meets
//! it. An echo's strength is the beam's sensitivity at its angle, times what the material sends back
//! at that incidence, times the fluctuation of the ping. The receiver's threshold grows with range. The
//! nearest echo above it is the reading. Beyond the critical angle a smooth surface sends (almost)
//! nothing back; the sound goes on as from a mirror and may return from elsewhere by the same way: a
//! ghost, too far. Rays decide energy and mirrors, never whether a thing is seen. Only among the
//! thousands of points of a scanned map, themselves samples, are echoes that are not the nearest
//! surface's sampled by rays alone.
//!
//! Use it for one ping at a time; a map that wants likelihoods needs an inverse model instead.
//! The thesis names the error (Fig. 6.5) without a model; this one is ours.

mod fate;
mod listening;
mod model;

use geometry::{Cone, ConeScene, Se2};
use run_context::RandomStream;

use crate::material::Material;
use fate::Fate;
use listening::Listening;
pub use model::{ModelRange, SonarModel};

/// What one ping returned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// The reading, metres, from `range_min_m` to `range_max_m`; the latter when nothing came back.
    pub range_m: f64,
    /// Why it is what it is.
    pub cause: EchoCause,
    /// Truth, for whoever judges: distance to the nearest point of any surface in the cone, edges
    /// included, metres, at most `range_max_m`. Exact.
    pub nearest_in_cone_m: f64,
}

/// Why a reading is what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EchoCause {
    /// The echo of a surface in the cone.
    Direct,
    /// No surface in the cone within range.
    Nothing,
    /// A surface was there, but its echo was too weak or went elsewhere; the reading is the
    /// greatest range or a ghost.
    Specular,
    /// An echo came and was missed.
    Dropout,
    /// Nearer than the sensor can measure.
    TooClose,
    /// Another sensor's sound.
    Crosstalk,
}

impl SonarModel {
    /// Fires once from `world_from_sensor` (x along the axis) into `scene`, whose tags are indices
    /// into `materials` (a tag beyond the list takes the first).
    ///
    /// Looks once into the cone, and casts at most one mirrored ray per ray; does not allocate.
    ///
    /// # Panics
    ///
    /// When `materials` is empty.
    pub fn ping(
        &self,
        world_from_sensor: Se2,
        scene: &impl ConeScene,
        materials: &[Material],
        rng: &mut RandomStream,
    ) -> Echo {
        assert!(!materials.is_empty(), "a scene has at least one material");
        // Every ping draws the same numbers in the same order, whatever it meets.
        let fate = Fate::draw(rng, self.strength_std_ratio);
        let cone = Cone::new(world_from_sensor, self.half_angle_rad, self.range_max_m);
        let heard = Listening { model: self, cone, scene, materials, fate: &fate }.hear();
        let echo = |range_m: f64, cause| Echo { range_m, cause, nearest_in_cone_m: heard.truth_m };

        if fate.crosstalk < self.crosstalk_prob {
            let end_m = heard.nearest_m.min(self.range_max_m);
            let range_m = self.range_min_m + fate.where_to * (end_m - self.range_min_m).max(0.0);
            return echo(self.in_steps(range_m), EchoCause::Crosstalk);
        }
        if heard.nearest_m > self.range_max_m {
            let lost = heard.truth_m < self.range_max_m;
            let cause = if lost { EchoCause::Specular } else { EchoCause::Nothing };
            return echo(self.range_max_m, cause);
        }
        if fate.dropout < self.dropout_prob {
            return echo(self.range_max_m, EchoCause::Dropout);
        }
        let std_m = self.range_std_m + self.range_std_ratio * heard.nearest_m;
        let measured_m = heard.nearest_m + std_m * fate.range_gauss;
        if measured_m < self.range_min_m {
            return echo(self.range_min_m, EchoCause::TooClose);
        }
        let cause = if heard.is_ghost { EchoCause::Specular } else { EchoCause::Direct };
        echo(self.in_steps(measured_m), cause)
    }

    /// The reading that stands for a range; whatever rounds to the last step is the last step.
    fn in_steps(&self, range_m: f64) -> f64 {
        if self.range_step_m == 0.0 {
            return range_m.min(self.range_max_m);
        }
        if range_m >= self.range_max_m - 0.5 * self.range_step_m {
            return self.range_max_m;
        }
        ((range_m / self.range_step_m).round() * self.range_step_m).max(self.range_min_m)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "clamped readings are exactly the limits")]
mod tests {
    use super::*;
    use crate::material::materials;
    use geometry::{Segment, SegmentWorld, Vec2};
    use proptest::prelude::*;
    use run_context::RunSeed;

    const PLASTER: u32 = 0;
    const GLASS: u32 = 2;
    const FABRIC: u32 = 3;

    /// A long wall whose foot from the sensor at the origin is `distance_m` away in the direction
    /// `normal_deg` from the axis.
    fn wall(distance_m: f64, normal_deg: f64, tag: u32) -> SegmentWorld {
        SegmentWorld::new([wall_segment(distance_m, normal_deg, tag)])
    }

    fn wall_segment(distance_m: f64, normal_deg: f64, tag: u32) -> (Segment, u32) {
        let turn = Se2::new(0.0, 0.0, normal_deg.to_radians());
        let end = |side_m| turn.transform_point(Vec2::new(distance_m, side_m));
        (Segment { a: end(-50.0), b: end(50.0) }, tag)
    }

    fn pings(model: &SonarModel, scene: &SegmentWorld, n: usize) -> Vec<Echo> {
        let mut rng = RunSeed(11).stream("sonar");
        (0..n).map(|_| model.ping(Se2::IDENTITY, scene, materials(), &mut rng)).collect()
    }

    /// No noise and no beam shape, but surfaces that mirror.
    fn honest() -> SonarModel {
        SonarModel { threshold_ratio: 1.0, ..SonarModel::ideal() }
    }

    fn ping(model: &SonarModel, scene: &SegmentWorld) -> Echo {
        pings(model, scene, 1)[0]
    }

    #[test]
    fn an_ideal_sonar_measures_a_wall_exactly() {
        for distance_m in [0.15, 0.2, 1.0, 4.999] {
            let echo = ping(&SonarModel::ideal(), &wall(distance_m, 0.0, PLASTER));
            assert!((echo.range_m - distance_m).abs() < 1e-9, "{echo:?}");
            assert_eq!(echo.cause, EchoCause::Direct);
        }
    }

    #[test]
    fn readings_are_clamped_at_both_ends() {
        let near = ping(&SonarModel::ideal(), &wall(0.1, 0.0, PLASTER));
        assert_eq!((near.range_m, near.cause), (0.15, EchoCause::TooClose));
        let far = ping(&SonarModel::ideal(), &wall(5.01, 0.0, PLASTER));
        assert_eq!((far.range_m, far.cause), (5.0, EchoCause::Nothing));
        assert_eq!(far.nearest_in_cone_m, 5.0);
        // Noise does not carry a reading past the end.
        let noisy = SonarModel { range_std_m: 0.5, ..SonarModel::ideal() };
        for echo in pings(&noisy, &wall(4.9, 0.0, PLASTER), 200) {
            assert!((0.15..=5.0).contains(&echo.range_m), "{echo:?}");
        }
    }

    proptest! {
        /// Geometry worked out by hand: the bearing in the cone closest to the wall's normal decides.
        #[test]
        fn the_nearest_surface_in_the_cone_is_the_truth(
            distance_m in 0.2..4.0, normal_deg in -70.0..70.0,
        ) {
            let echo = ping(&SonarModel::ideal(), &wall(distance_m, normal_deg, FABRIC));
            let off_deg = (normal_deg.abs() - 15.0).max(0.0);
            let expected = (distance_m / off_deg.to_radians().cos()).min(5.0);
            prop_assert!((echo.nearest_in_cone_m - expected).abs() < 1e-9, "{echo:?}");
        }

        /// Without beam shape and fluctuation, a smooth wall is heard up to its critical angle
        /// beyond the cone's edge, and not a degree more.
        #[test]
        fn a_smooth_wall_vanishes_beyond_its_critical_angle(normal_deg in -44.0..44.0) {
            let echo = ping(&honest(), &wall(1.0, normal_deg, GLASS));
            let critical_deg = materials()[GLASS as usize].specular_from_rad.to_degrees() + 15.0;
            prop_assume!((normal_deg.abs() - critical_deg).abs() > 0.2);
            let heard = normal_deg.abs() < critical_deg;
            let cause = if heard { EchoCause::Direct } else { EchoCause::Specular };
            prop_assert_eq!(echo.cause, cause);
            prop_assert_eq!(echo.range_m < 5.0, heard);
            prop_assert!(echo.nearest_in_cone_m < 2.0, "the truth knows the wall: {:?}", echo);
        }

        /// Left and right are alike.
        #[test]
        fn mirrored_scenes_give_mirrored_truth(d in 0.2..4.0, normal_deg in 0.0..60.0) {
            let model = honest();
            let left = ping(&model, &wall(d, normal_deg, PLASTER));
            let right = ping(&model, &wall(d, -normal_deg, PLASTER));
            prop_assert_eq!(left.cause, right.cause);
            prop_assert!((left.range_m - right.range_m).abs() < 1e-9);
        }
    }

    #[test]
    fn rough_walls_are_heard_where_smooth_ones_are_not() {
        let model = SonarModel { half_angle_rad: 0.0, ..honest() };
        let cause = |normal_deg, tag| ping(&model, &wall(1.0, normal_deg, tag)).cause;
        assert_eq!(cause(50.0, FABRIC), EchoCause::Direct);
        assert_eq!(cause(50.0, GLASS), EchoCause::Specular);
        assert_eq!(cause(5.0, GLASS), EchoCause::Direct);
    }

    #[test]
    fn plaster_beyond_its_angle_is_heard_only_from_near() {
        // 12 % · cos 60° of 5 m: 30 cm along the axis, and no farther.
        let model = SonarModel { half_angle_rad: 0.0, ..honest() };
        let at = |axis_m: f64| ping(&model, &wall(axis_m * 0.5, 60.0, PLASTER)).cause;
        assert_eq!(at(0.29), EchoCause::Direct);
        assert_eq!(at(0.31), EchoCause::Specular);
    }

    #[test]
    fn the_cone_narrows_with_range() {
        // A post at 13 degrees off the axis.
        let post = |range_m: f64| {
            let at = Se2::new(0.0, 0.0, 13.0_f64.to_radians());
            let a = at.transform_point(Vec2::new(range_m, -0.05));
            let b = at.transform_point(Vec2::new(range_m, 0.05));
            SegmentWorld::new([(Segment { a, b }, PLASTER)])
        };
        let quiet = SonarModel { edge_sensitivity_ratio: 0.1, ..honest() };
        assert_eq!(ping(&quiet, &post(0.5)).cause, EchoCause::Direct);
        assert_eq!(ping(&quiet, &post(2.0)).cause, EchoCause::Specular);
    }

    #[test]
    fn a_mirror_shows_what_is_behind_it_too_far_away() {
        // Glass at 45 degrees, 1 m ahead; the sound turns left and meets a wall 1.5 m on.
        let mirror = (Segment { a: Vec2::new(0.6, -0.4), b: Vec2::new(1.4, 0.4) }, GLASS);
        let wall = (Segment { a: Vec2::new(-5.0, 1.5), b: Vec2::new(5.0, 1.5) }, PLASTER);
        let scene = SegmentWorld::new([mirror, wall]);
        let model = SonarModel { half_angle_rad: 0.0, ghost_prob: 1.0, ..honest() };
        let echo = ping(&model, &scene);
        assert!((echo.range_m - 2.5).abs() < 1e-5, "{echo:?}");
        assert_eq!(echo.cause, EchoCause::Specular);
        assert!((echo.nearest_in_cone_m - 1.0).abs() < 1e-8);
        let deaf = SonarModel { ghost_prob: 0.0, ..model };
        assert_eq!(ping(&deaf, &scene).range_m, 5.0);
    }

    #[test]
    fn a_surface_is_heard_from_both_sides() {
        for normal_deg in [0.0, 180.0] {
            let scene = wall(1.0, normal_deg, PLASTER);
            let mut rng = RunSeed(1).stream("sonar");
            let facing = Se2::new(0.0, 0.0, normal_deg.to_radians());
            let echo = SonarModel::ideal().ping(facing, &scene, materials(), &mut rng);
            assert!((echo.range_m - 1.0).abs() < 1e-9, "{echo:?}");
        }
    }

    /// 20 000 pings at 3 m: mean and deviation within 5 of their own deviations.
    #[test]
    fn noise_has_the_stated_deviation() {
        let model = SonarModel {
            range_std_m: 0.005,
            range_std_ratio: 0.005,
            half_angle_rad: 0.0,
            ..SonarModel::ideal()
        };
        let n = 20_000.0_f64;
        let echoes = pings(&model, &wall(3.0, 0.0, PLASTER), 20_000);
        let mean = echoes.iter().map(|e| e.range_m).sum::<f64>() / n;
        let var = echoes.iter().map(|e| (e.range_m - mean).powi(2)).sum::<f64>() / (n - 1.0);
        assert!((mean - 3.0).abs() < 5.0 * 0.02 / n.sqrt(), "{mean}");
        assert!((var.sqrt() / 0.02 - 1.0).abs() < 5.0 / (2.0 * n).sqrt(), "{}", var.sqrt());
    }

    /// The module of a low-cost ring: whole inches from 6 to 254, and nothing between.
    #[test]
    fn readings_come_in_whole_steps() {
        let inches = SonarModel {
            range_min_m: 0.1524,
            range_max_m: 6.4516,
            range_step_m: 0.0254,
            ..SonarModel::ideal()
        };
        for (distance_m, n_inches) in
            [(0.1, 6.0), (0.1649, 6.0), (0.1652, 7.0), (1.0, 39.0), (6.43, 253.0), (6.44, 254.0)]
        {
            let echo = ping(&inches, &wall(distance_m, 0.0, PLASTER));
            assert!((echo.range_m - 0.0254 * n_inches).abs() < 1e-9, "{distance_m}: {echo:?}");
        }
        // The last step is the reading for nothing, to the bit.
        for distance_m in [6.44, 7.0] {
            assert_eq!(ping(&inches, &wall(distance_m, 0.0, PLASTER)).range_m, 6.4516);
        }
        let noisy = SonarModel { range_std_m: 0.01, crosstalk_prob: 0.2, ..inches };
        for echo in pings(&noisy, &wall(2.0, 0.0, PLASTER), 300) {
            let n_inches = echo.range_m / 0.0254;
            assert!((n_inches - n_inches.round()).abs() < 1e-9, "{echo:?}");
        }
    }

    /// 20 000 pings: binomial counts within 5 deviations.
    #[test]
    fn misfortunes_come_with_their_probabilities() {
        let model = SonarModel { dropout_prob: 0.05, crosstalk_prob: 0.02, ..SonarModel::ideal() };
        let echoes = pings(&model, &wall(2.0, 0.0, PLASTER), 20_000);
        let count = |cause| echoes.iter().filter(|e| e.cause == cause).count() as f64;
        let check = |cause, prob: f64| {
            let expected = 20_000.0 * prob;
            let bound = 5.0 * (expected * (1.0 - prob)).sqrt();
            assert!((count(cause) - expected).abs() < bound, "{cause:?}: {}", count(cause));
        };
        check(EchoCause::Crosstalk, 0.02);
        check(EchoCause::Dropout, 0.98 * 0.05);
        for echo in &echoes {
            match echo.cause {
                EchoCause::Dropout => assert_eq!(echo.range_m, 5.0),
                EchoCause::Crosstalk => assert!((0.15..=2.0).contains(&echo.range_m)),
                _ => assert!((echo.range_m - 2.0).abs() < 1e-9),
            }
        }
    }

    #[test]
    fn what_a_ping_meets_does_not_change_what_the_next_one_draws() {
        let model = SonarModel::default();
        let next_after = |scene: &SegmentWorld| {
            let mut rng = RunSeed(4).stream("sonar");
            model.ping(Se2::IDENTITY, scene, materials(), &mut rng);
            rng.next_u64()
        };
        assert_eq!(next_after(&wall(1.0, 0.0, GLASS)), next_after(&SegmentWorld::new([])));
    }

    /// A leg of a chair, of a table, a wire: four sides, turned about its own middle.
    fn leg(side_m: f64, distance_m: f64, bearing_rad: f64, turn_rad: f64) -> [Segment; 4] {
        let centre = Se2::new(0.0, 0.0, bearing_rad).transform_point(Vec2::new(distance_m, 0.0));
        let place = Se2::new(centre.x, centre.y, turn_rad);
        let corner = |x: f64, y: f64| place.transform_point(0.5 * side_m * Vec2::new(x, y));
        let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
        std::array::from_fn(|i| Segment { a: corners[i], b: corners[(i + 1) % 4] })
    }

    /// The least distance along 4001 rays of the cone, each intersected by hand: never less than the
    /// truth, and no more than a spacing of the rays allows.
    fn swept_m(walls: &[Segment], half_angle_rad: f64) -> f64 {
        let mut best = f64::INFINITY;
        for i in -2000..=2000 {
            let (s, c) = (half_angle_rad * f64::from(i) / 2000.0).sin_cos();
            for wall in walls {
                // d (c, s) = a + u (b − a), by Cramer's rule.
                let (x, y) = (wall.b.x - wall.a.x, wall.b.y - wall.a.y);
                let det = s * x - c * y;
                let (d, u) =
                    ((wall.a.y * x - wall.a.x * y) / det, (c * wall.a.y - s * wall.a.x) / det);
                if d >= 0.0 && (0.0..=1.0).contains(&u) {
                    best = best.min(d);
                }
            }
        }
        best
    }

    /// What the nine rays of the cone missed in three bearings of four, in a room of bearings.
    #[test]
    fn an_ideal_sonar_hears_every_thin_leg_in_its_cone() {
        let model = SonarModel { range_min_m: 0.0, ..SonarModel::ideal() };
        let mut n_within = 0;
        for side_m in [0.005, 0.02, 0.04, 0.06] {
            for distance_m in [0.2, 1.0, 2.5, 4.0] {
                for step in -60..=60 {
                    let bearing_rad = 0.0058 * f64::from(step);
                    let leg = leg(side_m, distance_m, bearing_rad, 0.7 * f64::from(step));
                    let swept = swept_m(&leg, model.half_angle_rad);
                    let scene = SegmentWorld::new(leg.map(|side| (side, GLASS)));
                    let echo = ping(&model, &scene);
                    let spacing_m = model.half_angle_rad / 2000.0 * distance_m;
                    let expected = swept.min(model.range_max_m);
                    // A corner may enter the cone by less than the rays are apart.
                    let apart = expected - echo.range_m;
                    let grazes = swept.is_infinite() && echo.range_m < distance_m + side_m;
                    assert!(
                        (-1e-9..=2.0 * spacing_m).contains(&apart) || grazes,
                        "{side_m} m at {distance_m} m, {bearing_rad} rad: {echo:?}, swept {swept}"
                    );
                    assert_eq!(echo.range_m, echo.nearest_in_cone_m);
                    n_within += usize::from(echo.cause == EchoCause::Direct);
                }
            }
        }
        // 15° of the 20° to either side that were tried, and the legs' own widths.
        assert!((1400..1600).contains(&n_within), "{n_within} of 1936");
    }

    /// Rays sample energy: an echo that a leg of cardboard sends back is heard between two of them,
    /// before a wall that is too askew to be heard and behind a pane that mirrors.
    #[test]
    fn a_leg_is_heard_beside_and_behind_what_is_not() {
        const CARDBOARD: u32 = 5;
        for step in -25..=25 {
            let bearing_rad = 0.01 * f64::from(step);
            let leg = leg(0.04, 1.0, bearing_rad, bearing_rad).map(|side| (side, CARDBOARD));
            let askew = wall_segment(1.2, 60.0, GLASS);
            // The pane stands askew at half a metre, on the other side of the axis.
            let aside = if bearing_rad < 0.0 { 1.0 } else { -1.0 };
            let pane =
                Segment { a: Vec2::new(0.45, 0.01 * aside), b: Vec2::new(0.6, 0.12 * aside) };
            let scene = SegmentWorld::new(leg.into_iter().chain([askew, (pane, GLASS)]));
            let echo = ping(&honest(), &scene);
            assert_eq!(echo.cause, EchoCause::Direct, "{bearing_rad}: {echo:?}");
            assert!((echo.range_m - 0.98).abs() < 0.005, "{bearing_rad}: {echo:?}");
            assert!(echo.nearest_in_cone_m < 0.5, "the truth knows the pane: {echo:?}");
        }
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let check = |model: SonarModel, expected: &str| {
            assert_eq!(model.checked().unwrap_err().to_string(), expected);
        };
        assert!(SonarModel::default().checked().is_ok());
        assert!(SonarModel::ideal().checked().is_ok());
        let model = SonarModel::default();
        check(SonarModel { n_rays: 0, ..model }, "n_rays = 0: must be from 1 to 999");
        check(
            SonarModel { dropout_prob: f64::NAN, ..model },
            "dropout_prob = NaN: must be from 0 to 1",
        );
        check(
            SonarModel { range_max_m: 0.1, ..model },
            "range_max_m = 0.1: must be from range_min_m to 100 m",
        );
    }
}
