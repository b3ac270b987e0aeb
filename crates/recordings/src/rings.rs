//! Known rings of sonars, for files that give ranges and no places.

use geometry::Se2;

use crate::recording::RingRig;

/// Which ring took the readings of a file that does not say.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Ring {
    /// That of the format: [`Ring::Listing8`] for MAT files, [`Ring::Artemic5`] for ARTEMIC's texts,
    /// [`Ring::Course8`] for sonar texts with stamps; a format that describes its rig uses that.
    #[default]
    File,
    /// The eight sonars that ARTEMIC's mapping program knows; in numbers the front of a Pioneer 3.
    ///
    /// Source: Galati (2011), thesis on ARTEMIC, listing 8.2 (`sonar_model`).
    Listing8,
    /// ARTEMIC's own five. Their angles are not given: every 45°, on the arc of [`Ring::Listing8`].
    Artemic5,
    /// All sixteen of a Pioneer 3-DX.
    ///
    /// Source: the robot's public parameter file (`SonarUnit` lines).
    Pioneer16,
    /// Eight at −90, −37.5, −22.5, −7.5, 7.5, 22.5, 37.5 and 90°, all in the robot's middle: their places
    /// are not given.
    Course8,
    /// Any other.
    Custom(RingRig),
}

/// x (mm), y (mm), azimuth (degrees).
type Mount = (f64, f64, f64);

const LISTING8: [Mount; 8] = [
    (69.0, 136.0, 90.0),
    (114.0, 119.0, 50.0),
    (148.0, 78.0, 30.0),
    (166.0, 27.0, 10.0),
    (166.0, -27.0, -10.0),
    (148.0, -78.0, -30.0),
    (114.0, -119.0, -50.0),
    (69.0, -136.0, -90.0),
];
const PIONEER_REAR8: [Mount; 8] = [
    (-157.0, -136.0, -90.0),
    (-203.0, -119.0, -130.0),
    (-237.0, -78.0, -150.0),
    (-255.0, -27.0, -170.0),
    (-255.0, 27.0, 170.0),
    (-237.0, 78.0, 150.0),
    (-203.0, 119.0, 130.0),
    (-157.0, 136.0, 90.0),
];
const ARTEMIC5: [Mount; 5] = [
    (69.0, 136.0, 90.0),
    (122.0, 109.0, 45.0),
    (168.0, 0.0, 0.0),
    (122.0, -109.0, -45.0),
    (69.0, -136.0, -90.0),
];
const COURSE8_DEG: [f64; 8] = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0];

/// Half of the cone's opening of all these sonars, degrees.
const HALF_ANGLE_DEG: f64 = 15.0;
/// Nearest and farthest reading of a Pioneer's sonars in its simulator and in its software, metres: the
/// recordings of ARTEMIC's mapping program hold 100 to 5000 mm.
const PIONEER_RANGE_M: (f64, f64) = (0.1, 5.0);
/// LV-MaxSonar-EZ0: 6 to 254 inches; 255 means that nothing came back.
const EZ0_RANGE_M: (f64, f64) = (0.1524, 6.4516);
/// The course's recording writes 5110 mm where nothing came back.
const COURSE_RANGE_M: (f64, f64) = (0.1, 5.11);

impl Ring {
    /// The rings that have a name to ask for.
    pub const NAMED: &'static [Self] =
        &[Self::Artemic5, Self::Listing8, Self::Pioneer16, Self::Course8, Self::File];

    /// The ring, or `None` for [`Ring::File`].
    pub fn rig(&self) -> Option<RingRig> {
        match self {
            Self::File => None,
            Self::Listing8 => Some(ring(&LISTING8, PIONEER_RANGE_M)),
            Self::Artemic5 => Some(ring(&ARTEMIC5, EZ0_RANGE_M)),
            Self::Pioneer16 => Some(ring(&[LISTING8, PIONEER_REAR8].concat(), PIONEER_RANGE_M)),
            Self::Course8 => Some(ring(&COURSE8_DEG.map(|a| (0.0, 0.0, a)), COURSE_RANGE_M)),
            Self::Custom(rig) => Some(rig.clone()),
        }
    }

    /// What people call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Listing8 => "listing8",
            Self::Artemic5 => "artemic5",
            Self::Pioneer16 => "pioneer16",
            Self::Course8 => "course8",
            Self::Custom(_) => "custom",
        }
    }

    /// What missions call it: ARTEMIC's two rings by the number of their sonars.
    pub fn also(&self) -> Option<&'static str> {
        match self {
            Self::Artemic5 => Some("five"),
            Self::Listing8 => Some("eight"),
            Self::File | Self::Pioneer16 | Self::Course8 | Self::Custom(_) => None,
        }
    }

    /// The ring of either name; `None` if there is none (`custom` has no name to ask for).
    pub fn by_name(name: &str) -> Option<Self> {
        let is_named = |ring: &&Self| ring.name() == name || ring.also() == Some(name);
        Self::NAMED.iter().find(is_named).cloned()
    }

    /// This ring, or `default` where the file should say and cannot.
    pub(crate) fn or(&self, default: Self) -> (RingRig, &'static str) {
        let chosen = if *self == Self::File { default } else { self.clone() };
        let name = chosen.name();
        let rig = chosen.rig().unwrap_or_else(|| ring(&[], PIONEER_RANGE_M));
        (rig, name)
    }
}

fn ring(mounts: &[Mount], (range_min_m, range_max_m): (f64, f64)) -> RingRig {
    let mount = |&(x_mm, y_mm, azimuth_deg): &Mount| {
        Se2::new(x_mm / 1000.0, y_mm / 1000.0, azimuth_deg.to_radians())
    };
    RingRig {
        base_from_sensors: mounts.iter().map(mount).collect(),
        half_angle_rad: HALF_ANGLE_DEG.to_radians(),
        range_min_m,
        range_max_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_models::RobotModel;

    /// The catalogue's robots come from the same public files, typed in by somebody else.
    #[test]
    fn the_rings_are_those_of_the_catalogue() {
        let cases = [
            (Ring::Listing8, "artemic8"),
            (Ring::Artemic5, "artemic5"),
            (Ring::Pioneer16, "pioneer3dx"),
        ];
        for (ring, robot) in cases {
            let rig = ring.rig().unwrap();
            let model = RobotModel::by_name(robot).unwrap();
            assert_eq!(rig.base_from_sensors.len(), model.sonars.len(), "{robot}");
            for (ours, theirs) in rig.base_from_sensors.iter().zip(&model.sonars) {
                let theirs = theirs.base_from_sensor.se2();
                assert!((ours.x_m - theirs.x_m).abs() < 1e-9, "{robot} {ours:?} {theirs:?}");
                assert!((ours.y_m - theirs.y_m).abs() < 1e-9, "{robot} {ours:?} {theirs:?}");
                assert!((ours.yaw_rad - theirs.yaw_rad).abs() < 1e-9, "{robot}");
            }
        }
    }

    #[test]
    fn rings_are_found_by_their_names() {
        for ring in Ring::NAMED {
            assert_eq!(Ring::by_name(ring.name()).as_ref(), Some(ring));
            assert_eq!(
                ring.also().map(|also| Ring::by_name(also).unwrap()),
                ring.also().map(|_| ring.clone())
            );
        }
        assert_eq!(Ring::by_name("eight"), Some(Ring::Listing8));
        assert_eq!(Ring::by_name("custom"), None);
        assert_eq!(Ring::by_name("Listing8"), None);
        assert_eq!(Ring::File.rig(), None);
    }
}
