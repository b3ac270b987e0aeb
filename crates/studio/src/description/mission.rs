//! What a mission's page can show.

use missions::Scene;

use super::item::{Layer, Panel};
use crate::crowd::n_robots_in_full;

fn has_robot(scene: &Scene) -> bool {
    !scene.robots.is_empty()
}

fn has_sonar(scene: &Scene) -> bool {
    scene.robots.iter().any(|robot| !robot.sonars.is_empty())
}

fn has_program(scene: &Scene) -> bool {
    scene.program.is_some()
}

/// The panels of a mission.
pub(super) const RUN_PANELS: [Panel<Scene>; 6] = [
    Panel {
        key: "program",
        title: "Program",
        digit: 1,
        row: 0,
        about: "the decision program, each variable lit by its state",
        is_offered: has_program,
    },
    Panel {
        key: "signals",
        title: "Signals",
        digit: 2,
        row: 0,
        about: "the program's variables over the last 30 s",
        is_offered: has_program,
    },
    Panel {
        key: "avoider",
        title: "Avoider",
        digit: 3,
        row: 0,
        about: "the nine states of obstacle avoidance, and ranges against limits",
        is_offered: has_sonar,
    },
    Panel {
        key: "plots",
        title: "Plots",
        digit: 4,
        row: 1,
        about: "numbers over time",
        is_offered: has_robot,
    },
    Panel {
        key: "wire",
        title: "Wire",
        digit: 5,
        row: 1,
        about: "every packet between the nodes, decoded; lines are cut and mended here",
        is_offered: |scene| {
            !scene.links.is_empty() && n_robots_in_full(scene) == scene.robots.len()
        },
    },
    Panel {
        key: "figures",
        title: "Figures & log",
        digit: 6,
        row: 1,
        about: "figures of the run and of the robot now, and what happened",
        is_offered: |_| true,
    },
];

/// The layers of a mission.
pub(super) const RUN_LAYERS: [Layer<Scene>; 13] = [
    Layer {
        key: "pheromones",
        label: "Pheromone field",
        colour: "rgb(var(--heat-high))",
        is_on: true,
        looks: "violet glow",
        about: "how strongly the ground smells, by the sum over the cells within the perception radius",
        is_offered: |scene| scene.pheromones.is_some(),
    },
    Layer {
        key: "tags",
        label: "Tags in the floor",
        colour: "var(--map-tag)",
        is_on: true,
        looks: "small squares, the fuller the stronger",
        about: "the tags that answer and what they stored when the run began; rings: where a robot's readers recognise one",
        is_offered: |scene| scene.tags.is_some(),
    },
    Layer {
        key: "plan",
        label: "Planned path",
        colour: "var(--map-plan)",
        is_on: true,
        looks: "green dots",
        about: "the line from which the trail was made; the robot does not know it",
        is_offered: |scene| scene.planned_path_m.len() > 1,
    },
    Layer {
        key: "trail",
        label: "Driven path",
        colour: "var(--map-trail)",
        is_on: true,
        looks: "red line",
        about: "where the robot really went; it fades within a minute",
        is_offered: has_robot,
    },
    Layer {
        key: "preview",
        label: "Scout preview",
        colour: "var(--map-preview)",
        is_on: true,
        looks: "pink beads",
        about: "the trail or path ahead, as far as the navigator knows it",
        is_offered: has_robot,
    },
    Layer {
        key: "estimate",
        label: "Estimated pose",
        colour: "var(--map-estimate)",
        is_on: true,
        looks: "blue dashed outline, blue ellipse",
        about: "where the robot believes it is, and its 95 % region of doubt",
        is_offered: has_robot,
    },
    Layer {
        key: "laser",
        label: "Laser",
        colour: "var(--map-laser)",
        is_on: true,
        looks: "blue-green points on a pale fan",
        about: "the newest scan of each planar scanner where it was taken: points are echoes, the fan is seen and free; where there is no fan nothing is known",
        is_offered: |scene| scene.robots.iter().any(|robot| !robot.scanners.is_empty()),
    },
    Layer {
        key: "sonar",
        label: "Sonar cones",
        colour: "var(--map-sonar-hit)",
        is_on: true,
        looks: "amber fan with a bold arc: an echo; pale dashed: none",
        about: "what the eight front sonars report",
        is_offered: has_sonar,
    },
    Layer {
        key: "bubble",
        label: "Sensitivity bubble",
        colour: "var(--map-bubble)",
        is_on: true,
        looks: "red arcs",
        about: "the distance below which the avoider takes over; full red: something is inside",
        is_offered: has_sonar,
    },
    Layer {
        key: "contacts",
        label: "Contacts",
        colour: "var(--bad)",
        is_on: true,
        looks: "red stars",
        about: "where a robot began to touch something, since the page was opened",
        is_offered: |scene| scene.robots.iter().any(|robot| !robot.is_elsewhere),
    },
    Layer {
        key: "zones",
        label: "Motion zones",
        colour: "var(--map-zone-on)",
        is_on: true,
        looks: "dashed areas",
        about: "what the detectors watch; orange while they see somebody",
        is_offered: |scene| scene.devices.iter().any(|device| !device.area_m.is_empty()),
    },
    Layer {
        key: "names",
        label: "Names",
        colour: "var(--map-room)",
        is_on: true,
        looks: "grey words",
        about: "rooms, furniture and, where there are several, robots",
        is_offered: |scene| {
            !scene.rooms.is_empty() || !scene.things.is_empty() || scene.robots.len() > 1
        },
    },
    Layer {
        key: "grid",
        label: "Grid, 1 m",
        colour: "var(--map-grid)",
        is_on: true,
        looks: "pale lines",
        about: "one metre",
        is_offered: |_| true,
    },
];
