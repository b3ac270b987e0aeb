//! What the pages can show, each thing listed once: panels and layers, with what a session must have for them.
//!
//! A page is told these lists and offers what is in them; it has a drawing for each layer and a view for each panel, and
//! no list of its own. The guide's tables are written from here by a test. What is a number is in
//! [`missions::SIGNALS`].

use missions::{PLOTS, SIGNALS, Scene, Signal};
use serde::Serialize;

mod item;
mod mission;
mod survey;

pub(crate) use item::SurveyHas;
use item::{Layer, Panel};
use mission::{RUN_LAYERS, RUN_PANELS};
use survey::{SURVEY_LAYERS, SURVEY_PANELS};

/// What a page can offer of a session.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Offer {
    pub panels: Vec<PanelInfo>,
    pub layers: Vec<LayerInfo>,
}

/// A panel as the page is told of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PanelInfo {
    pub key: &'static str,
    pub title: &'static str,
    pub digit: u8,
    pub row: usize,
}

/// A layer as the page is told of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LayerInfo {
    pub key: &'static str,
    pub label: &'static str,
    pub colour: &'static str,
    pub on: bool,
}

/// A signal as the page is told of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SignalInfo {
    pub id: &'static str,
    pub title: &'static str,
    /// The plot, and the name of the curve in it.
    pub curve: Option<(&'static str, &'static str)>,
    pub is_figure: bool,
    pub is_seen_from_outside: bool,
}

/// A plot as the page is told of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PlotInfo {
    pub id: &'static str,
    pub title: &'static str,
    pub unit: &'static str,
    pub per_si_ratio: f64,
    pub least: [f64; 2],
    pub empty: &'static str,
}

fn offer<S>(panels: &[Panel<S>], layers: &[Layer<S>], has: &S) -> Offer {
    let panels = panels.iter().filter(|panel| (panel.is_offered)(has));
    let layers = layers.iter().filter(|layer| (layer.is_offered)(has));
    Offer {
        panels: panels
            .map(|p| PanelInfo { key: p.key, title: p.title, digit: p.digit, row: p.row })
            .collect(),
        layers: layers
            .map(|l| LayerInfo { key: l.key, label: l.label, colour: l.colour, on: l.is_on })
            .collect(),
    }
}

/// What a mission's page offers.
pub(crate) fn of_run(scene: &Scene) -> Offer {
    offer(&RUN_PANELS, &RUN_LAYERS, scene)
}

/// What a survey's page offers.
pub(crate) fn of_survey(has: SurveyHas) -> Offer {
    offer(&SURVEY_PANELS, &SURVEY_LAYERS, &has)
}

/// The plots of a mission.
pub(crate) fn plots(scene: &Scene) -> Vec<PlotInfo> {
    let told = PLOTS.iter().filter(|plot| plot.is_offered(scene)).map(|plot| PlotInfo {
        id: plot.id,
        title: plot.title,
        unit: plot.unit,
        per_si_ratio: plot.per_si_ratio,
        least: plot.least,
        empty: plot.empty,
    });
    told.collect()
}

/// The signals of each robot, and of the run, in the order of their values.
pub(crate) fn signals() -> [Vec<SignalInfo>; 2] {
    let told = |signal: &'static Signal| SignalInfo {
        id: signal.id,
        title: signal.title,
        curve: signal.curve,
        is_figure: signal.is_figure,
        is_seen_from_outside: signal.is_seen_from_outside,
    };
    let of = |robot: bool| SIGNALS.iter().filter(move |s| s.is_of_robot() == robot).map(told);
    [of(true).collect(), of(false).collect()]
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use expect_test::expect_file;
    use missions::{Mission, Run};

    use super::*;

    fn scene(mission: &str) -> Scene {
        let mission = Mission::load(mission, &[]).unwrap();
        let seed = mission.seed();
        Run::new(mission, seed).unwrap().scene()
    }

    fn keys(offer: &Offer) -> (Vec<&'static str>, Vec<&'static str>) {
        let panels = offer.panels.iter().map(|panel| panel.key).collect();
        (panels, offer.layers.iter().map(|layer| layer.key).collect())
    }

    #[test]
    fn a_mission_offers_what_it_has() {
        let home = of_run(&scene("doorbell"));
        let (panels, layers) = keys(&home);
        assert_eq!(panels, ["program", "signals", "avoider", "plots", "wire", "figures"]);
        assert!(layers.contains(&"pheromones") && layers.contains(&"zones"), "{layers:?}");
        assert!(!layers.contains(&"laser") && !layers.contains(&"tags"), "{layers:?}");
        let (panels, layers) = keys(&of_run(&scene("decision-rig")));
        assert_eq!(panels, ["program", "signals", "figures"], "no robot, no links");
        assert!(!layers.iter().any(|key| ["trail", "sonar", "pheromones"].contains(key)));
        let (panels, layers) = keys(&of_run(&scene("one-obstacle")));
        assert_eq!(panels, ["avoider", "plots", "wire", "figures"]);
        assert!(!layers.contains(&"pheromones"), "{layers:?}");
        let (_, layers) = keys(&of_run(&scene("laser-ward")));
        assert!(layers.contains(&"laser"), "{layers:?}");
        let (_, layers) = keys(&of_run(&scene("tag-trail")));
        assert!(layers.contains(&"tags"), "{layers:?}");
        let plots = |mission| plots(&scene(mission)).iter().map(|p| p.id).collect::<Vec<_>>();
        assert!(plots("doorbell").contains(&"smell") && !plots("one-obstacle").contains(&"smell"));
    }

    #[test]
    fn a_survey_offers_what_its_recording_has() {
        let laser = of_survey(SurveyHas { sonar: false, truth: false });
        let sonar = of_survey(SurveyHas { sonar: true, truth: true });
        let has = |offer: &Offer, key| offer.layers.iter().any(|layer| layer.key == key);
        assert!(!has(&laser, "truth") && has(&sonar, "truth"));
        assert!(!has(&laser, "patch") && has(&sonar, "patch"));
        assert_eq!(sonar.panels.len(), laser.panels.len() + 1);
    }

    /// A page asks for nothing by a digit that is not its own.
    #[test]
    fn digits_and_names_are_told_apart() {
        fn check<S>(panels: &[Panel<S>], layers: &[Layer<S>]) {
            for (index, panel) in panels.iter().enumerate() {
                assert_eq!(usize::from(panel.digit), index + 1);
                assert!(panels[..index].iter().all(|other| other.key != panel.key));
            }
            for (index, layer) in layers.iter().enumerate() {
                assert!(layers[..index].iter().all(|other| other.key != layer.key));
            }
        }
        check(&RUN_PANELS, &RUN_LAYERS);
        check(&SURVEY_PANELS, &SURVEY_LAYERS);
    }

    /// The text with what stands between two marks replaced.
    fn with(text: &str, mark: &str, table: &str) -> String {
        let (begin, end) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->\n"));
        let (before, rest) = text.split_once(&begin).expect("a mark where the table begins");
        let (_, after) = rest.split_once(&end).expect("a mark where the table ends");
        format!("{before}{begin}{table}{end}{after}")
    }

    fn layer_table<S>(layers: &[Layer<S>]) -> String {
        let mut table = "| layer | how it looks | what it is |\n| --- | --- | --- |\n".to_owned();
        for Layer { label, looks, about, .. } in layers {
            writeln!(table, "| {label} | {looks} | {about} |").unwrap();
        }
        table
    }

    fn panel_table<S>(panels: &[Panel<S>]) -> String {
        let mut table = "| key | panel | what it shows |\n| --- | --- | --- |\n".to_owned();
        for Panel { digit, title, about, .. } in panels {
            writeln!(table, "| `{digit}` | {title} | {about} |").unwrap();
        }
        table
    }

    fn signal_table() -> String {
        let mut table =
            "| signal | name | where | what it is |\n| --- | --- | --- | --- |\n".to_owned();
        for signal in &SIGNALS {
            let plot = signal.curve.and_then(|(id, _)| PLOTS.iter().find(|plot| plot.id == id));
            let places = [
                plot.map(|plot| format!("plot *{}*", plot.title)),
                signal.is_figure.then(|| "figures".to_owned()),
            ];
            let places: Vec<_> = places.into_iter().flatten().collect();
            let (title, id, about) = (signal.title, signal.id, signal.about);
            writeln!(table, "| {title} | `{id}` | {} | {about} |", places.join(", ")).unwrap();
        }
        table
    }

    /// The stand-in for the program, with which pages are tested, tells the same lists.
    #[test]
    fn the_pages_own_tests_are_told_the_same() {
        let [robot_signals, run_signals] = signals();
        let panel =
            |p: &Panel<Scene>| PanelInfo { key: p.key, title: p.title, digit: p.digit, row: p.row };
        let layer = |l: &Layer<Scene>| LayerInfo {
            key: l.key,
            label: l.label,
            colour: l.colour,
            on: l.is_on,
        };
        let told = serde_json::json!({
            "panels": RUN_PANELS.iter().map(panel).collect::<Vec<_>>(),
            "layers": RUN_LAYERS.iter().map(layer).collect::<Vec<_>>(),
            "plots": plots(&scene("doorbell")),
            "robot_signals": robot_signals,
            "run_signals": run_signals,
        });
        let text = serde_json::to_string_pretty(&told).unwrap() + "\n";
        expect_file!["../web/tests/mock/offer.json"].assert_eq(&text);
    }

    /// Nothing is offered that the page does not know: its bundle names every panel and layer.
    #[test]
    fn the_page_has_a_drawing_for_every_layer_and_a_view_for_every_panel() {
        let page = include_str!("../web/dist/assets/studio.js");
        let layers = RUN_LAYERS.iter().map(|layer| layer.key);
        for key in layers.chain(SURVEY_LAYERS.iter().map(|layer| layer.key)) {
            assert!(page.contains(&format!(".has(\"{key}\")")), "layer {key}");
        }
        let panels = RUN_PANELS.iter().map(|panel| panel.key);
        for key in panels.chain(SURVEY_PANELS.iter().map(|panel| panel.key)) {
            assert!(page.contains(&format!("{key}:")), "panel {key}");
        }
    }

    /// `UPDATE_EXPECT=1` brings the guide up to date.
    #[test]
    fn the_guide_has_every_panel_layer_and_signal() {
        let guide = include_str!("../../../docs/guide/studio.md");
        let wanted = with(guide, "panels of a mission", &panel_table(&RUN_PANELS));
        let wanted = with(&wanted, "layers of a mission", &layer_table(&RUN_LAYERS));
        let wanted = with(&wanted, "signals", &signal_table());
        let wanted = with(&wanted, "panels of a survey", &panel_table(&SURVEY_PANELS));
        let wanted = with(&wanted, "layers of a survey", &layer_table(&SURVEY_LAYERS));
        expect_file!["../../../docs/guide/studio.md"].assert_eq(&wanted);
    }
}
