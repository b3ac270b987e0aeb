//! Which settings a survey reads: what somebody set and nothing would obey is refused, not passed over.

use recordings::Rig;

use super::{Method, Mode, SurveyConfig};

impl SurveyConfig {
    /// A sentence for each of `overrides` (`table.key=value`) that a survey of a recording by `rig` would not obey.
    ///
    /// Settings files are not judged: the one that a survey leaves behind holds every key.
    pub fn unread(&self, rig: &Rig, overrides: &[String]) -> Vec<String> {
        let key =
            |given: &String| given.split_once('=').map_or("", |(key, _)| key.trim()).to_owned();
        let reason = |given: &String| {
            let key = key(given);
            let reason = self.why_unread(rig, &key)?;
            Some(format!("{key} would change nothing: {reason}"))
        };
        overrides.iter().filter_map(reason).collect()
    }

    fn why_unread(&self, rig: &Rig, key: &str) -> Option<String> {
        let (table, name) = key.split_once('.').unwrap_or((key, ""));
        let on_laser = matches!(rig, Rig::Laser(_));
        let by_sonar = !on_laser && self.method() != Method::Odometry;
        let classic = by_sonar && matches!(self.mode(), Mode::Thesis | Mode::Listing);
        match (table, name) {
            ("survey", "mode") if self.mode() == Mode::Default => None,
            ("survey", "mode") if on_laser => {
                Some("it is a form of the sonar method, and this is a laser's recording".to_owned())
            }
            ("survey", "mode") if !by_sonar => {
                Some("it is a form of the sonar method; leave survey.method out".to_owned())
            }
            ("sonar", _) if on_laser => Some(
                "this is a laser's recording; `cairn map --keys` has the tables [map] and [laser]"
                    .to_owned(),
            ),
            ("laser", _) if !on_laser => Some(
                "this is a recording of sonars; `cairn map --keys` has the table [sonar]"
                    .to_owned(),
            ),
            ("map", "resolution_m") if classic => Some(
                "the side of a sonar map's cell is sonar.classic.pose_scale_m in this form"
                    .to_owned(),
            ),
            ("map", "resolution_m") if !on_laser => {
                Some("the side of a sonar map's cell is sonar.resolution_m".to_owned())
            }
            ("map", "range_max_m") if !on_laser => Some(
                "it is a laser's; how far echoes count is sonar.cone.occupied_range_m".to_owned(),
            ),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use geometry::Se2;
    use recordings::{LaserRig, RingRig};

    use super::*;

    #[test]
    fn what_a_survey_does_not_read_is_said_and_what_it_reads_is_not() {
        let laser = Rig::Laser(LaserRig {
            base_from_sensor: Se2::IDENTITY,
            first_beam_rad: -1.5,
            beam_spacing_rad: 0.01,
            n_beams: 301,
            range_max_m: 80.0,
        });
        let ring = Rig::Ring(RingRig {
            base_from_sensors: vec![Se2::IDENTITY],
            half_angle_rad: 0.2,
            range_min_m: 0.1,
            range_max_m: 5.0,
        });
        let unread = |rig: &Rig, given: &[&str]| {
            let given: Vec<String> = given.iter().map(|&g| g.to_owned()).collect();
            let config = SurveyConfig::default().with(&given).unwrap();
            config.unread(rig, &given).len()
        };
        assert_eq!(unread(&laser, &["survey.mode=thesis"]), 1);
        assert_eq!(unread(&ring, &["survey.mode=thesis"]), 0);
        assert_eq!(unread(&ring, &["survey.mode=graph", "survey.method=odometry"]), 1);
        assert_eq!(unread(&laser, &["survey.mode=default"]), 0);
        assert_eq!(unread(&laser, &["map.resolution_m=0.1", "sonar.correct=false"]), 1);
        assert_eq!(unread(&ring, &["map.resolution_m=0.1", "sonar.correct=false"]), 1);
        assert_eq!(unread(&ring, &["map.occupied_prob=0.7", "laser.loops.radius_m=5.0"]), 1);
        assert_eq!(unread(&laser, &["map.range_max_m=20.0", "laser.loops.radius_m=5.0"]), 0);
    }
}
