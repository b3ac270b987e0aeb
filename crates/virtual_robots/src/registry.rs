//! Which firmware a robot of the catalogue has: one line for each protocol.

use std::sync::Arc;

use robot_models::RobotModel;
use run_context::RandomStream;

use crate::{Board, BoardConfig, create::CreateFirmware, pioneer::PioneerFirmware};

/// The list: protocol and constructor. A robot with a line of its own adds itself here.
const BOARDS: &[(&str, Build)] =
    &[("arcos", PioneerFirmware::board), ("create_oi", CreateFirmware::board)];

type Build = fn(Arc<RobotModel>, &BoardConfig, RandomStream) -> Box<dyn Board>;

/// A robot for which there is no firmware.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoBoard {
    /// The catalogue says nothing of its line.
    #[error("{title} has no line in the catalogue: its bytes are not simulated")]
    NoLine {
        /// The robot.
        title: String,
    },
    /// Its protocol is not in the list.
    #[error(
        "{title} speaks `{protocol}`, for which there is no firmware here; there is for {known}"
    )]
    Unknown {
        /// The robot.
        title: String,
        /// What its catalogue file says.
        protocol: String,
        /// The protocols there are, as prose.
        known: String,
    },
}

/// Firmware that has just been switched on; `rng` is the randomness of its sensors.
///
/// # Errors
///
/// [`NoBoard`], which names the protocols there are.
pub fn board(
    model: &Arc<RobotModel>,
    config: &BoardConfig,
    rng: RandomStream,
) -> Result<Box<dyn Board>, NoBoard> {
    let title = || model.title.clone();
    let Some(protocol) = model.protocol() else {
        return Err(NoBoard::NoLine { title: title() });
    };
    let Some((_, build)) = BOARDS.iter().find(|(known, _)| *known == protocol) else {
        let known: Vec<String> = BOARDS.iter().map(|(known, _)| format!("`{known}`")).collect();
        let (protocol, known) = (protocol.to_owned(), known.join(", "));
        return Err(NoBoard::Unknown { title: title(), protocol, known });
    };
    Ok(build(Arc::clone(model), config, rng))
}

/// Whether there is firmware for that robot.
pub fn has_board(model: &RobotModel) -> bool {
    model.protocol().is_some_and(|protocol| BOARDS.iter().any(|(known, _)| *known == protocol))
}

#[cfg(test)]
mod tests {
    use run_context::RunSeed;

    use super::*;
    use crate::BatteryConfig;

    fn built(model: RobotModel) -> Result<&'static [&'static str], NoBoard> {
        let config = BoardConfig { name: "x".to_owned(), battery: BatteryConfig::default() };
        board(&Arc::new(model), &config, RunSeed(1).stream("x")).map(|board| board.ports())
    }

    #[test]
    fn every_robot_of_the_catalogue_that_has_a_line_has_firmware() {
        for model in RobotModel::catalogue() {
            assert_eq!(has_board(&model), model.line.is_some(), "{}", model.name);
            assert_eq!(built(model.clone()).is_ok(), model.line.is_some(), "{}", model.name);
        }
    }

    #[test]
    fn a_robot_without_firmware_is_told_what_there_is() {
        let mut model = RobotModel::by_name("artemic5").unwrap();
        let refused = built(model.clone()).unwrap_err().to_string();
        assert!(refused.starts_with("ARTEMIC (5 sonars) has no line"), "{refused}");
        model.line = RobotModel::by_name("pioneer3dx").unwrap().line;
        model.line.as_mut().unwrap().protocol = "semaphore".to_owned();
        let refused = built(model).unwrap_err().to_string();
        assert!(refused.contains("`semaphore`") && refused.contains("`arcos`"), "{refused}");
    }
}
