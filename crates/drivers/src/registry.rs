//! Which driver a robot of the catalogue needs: one line for each protocol.

use robot_models::RobotModel;

use crate::{CreateDriver, Driver, DriverConfig, PioneerDriver};

/// The list: protocol and constructor. A robot with a line of its own adds itself here.
const DRIVERS: &[(&str, Build)] =
    &[("arcos", PioneerDriver::for_robot), ("create_oi", CreateDriver::for_robot)];

type Build = fn(&RobotModel, &DriverConfig) -> Box<dyn Driver>;

/// A robot for which there is no driver.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDriver {
    /// The catalogue says nothing of its line.
    #[error("{title} has no line in the catalogue: its bytes are not known here")]
    NoLine {
        /// The robot.
        title: String,
    },
    /// Its protocol is not in the list.
    #[error("{title} speaks `{protocol}`, for which there is no driver here; there is for {known}")]
    Unknown {
        /// The robot.
        title: String,
        /// What its catalogue file says.
        protocol: String,
        /// The protocols there are, as prose.
        known: String,
    },
}

/// A driver that will connect at its first step, with motors to be switched on.
///
/// # Errors
///
/// [`NoDriver`], which names the protocols there are.
pub fn driver(model: &RobotModel, config: &DriverConfig) -> Result<Box<dyn Driver>, NoDriver> {
    let title = || model.title.clone();
    let Some(protocol) = model.protocol() else {
        return Err(NoDriver::NoLine { title: title() });
    };
    let Some((_, build)) = DRIVERS.iter().find(|(known, _)| *known == protocol) else {
        let known: Vec<String> = DRIVERS.iter().map(|(known, _)| format!("`{known}`")).collect();
        let (protocol, known) = (protocol.to_owned(), known.join(", "));
        return Err(NoDriver::Unknown { title: title(), protocol, known });
    };
    Ok(build(model, config))
}

/// Whether there is a driver for that robot.
pub fn has_driver(model: &RobotModel) -> bool {
    model.protocol().is_some_and(|protocol| DRIVERS.iter().any(|(known, _)| *known == protocol))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LineTiming;

    const CONFIG: DriverConfig = DriverConfig {
        wheel_speed_max_mps: 0.5,
        acceleration_mps2: 0.3,
        range_max_m: 5.0,
        line: LineTiming { baud: None, latency: std::time::Duration::ZERO },
    };

    #[test]
    fn every_robot_of_the_catalogue_that_has_a_line_has_a_driver() {
        for model in RobotModel::catalogue() {
            assert_eq!(has_driver(&model), model.line.is_some(), "{}", model.name);
            assert_eq!(driver(&model, &CONFIG).is_ok(), model.line.is_some(), "{}", model.name);
            assert_eq!(has_driver(&model), virtual_robots::has_board(&model), "{}", model.name);
            let reader = |protocol| wire::reader(protocol, wire::Towards::Robot).is_some();
            assert_eq!(model.protocol().is_some_and(reader), model.line.is_some());
        }
    }

    #[test]
    fn a_robot_without_driver_is_told_what_there_is() {
        let mut model = RobotModel::by_name("artemic8").unwrap();
        let refused = driver(&model, &CONFIG).unwrap_err().to_string();
        assert!(refused.starts_with("ARTEMIC (8 sonars) has no line"), "{refused}");
        model.line = RobotModel::by_name("peoplebot").unwrap().line;
        model.line.as_mut().unwrap().protocol = "semaphore".to_owned();
        let refused = driver(&model, &CONFIG).unwrap_err().to_string();
        assert!(refused.contains("`semaphore`") && refused.contains("`arcos`"), "{refused}");
    }
}
