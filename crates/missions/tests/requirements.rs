//! Requirements of success speak of any robot, and what nobody knows does not hold.
#![expect(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::{io::Read as _, net::TcpListener, thread};

use missions::{Check, Mission, Run};
use run_context::RunSeed;

const HEAD: &str = "[mission]\nname = \"t\"\nduration_max_s = 30.0\n";
/// Two robots on two paths; the second begins 0.4 m beside its own.
const TWO: &str = "[[robots]]\nname = \"anna\"\nstart = [0.0, 0.0, 0.0]\nline.kind = \"direct\"\n[robots.mind]\n\
    how = { method = \"path\", path_m = [[0.0, 0.0], [4.0, 0.0]] }\n\
    [[robots]]\nname = \"bert\"\nstart = [0.0, 2.4, 0.0]\nline.kind = \"direct\"\n[robots.mind]\n\
    how = { method = \"path\", path_m = [[0.0, 2.0], [4.0, 2.0]] }\n\
    [[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"anna\"\npose = [4.0, 0.0, 0.0]\n\
    [[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"bert\"\npose = [4.0, 2.0, 0.0]\n";

fn checks(text: &str) -> Vec<Check> {
    let mission = Mission::parse("t.toml", text, &[]).unwrap();
    Run::new(mission, RunSeed(1)).unwrap().run_to_end().checks.clone()
}

fn warnings(text: &str) -> String {
    Mission::parse("t.toml", text, &[]).unwrap().warnings().join("\n")
}

#[test]
fn each_robot_has_its_own_path_to_keep_to() {
    let on_path = |robot: &str, rms_max_m: f64| {
        format!("[[success.on_path]]\nrobot = \"{robot}\"\nrms_max_m = {rms_max_m}\n")
    };
    let text = [HEAD, TWO, &on_path("anna", 0.01), &on_path("bert", 0.01), &on_path("bert", 0.4)];
    let found = checks(&text.concat());
    let passed: Vec<bool> = found.iter().map(|check| check.passed).collect();
    assert_eq!(passed, [true, false, true], "{found:?}");
    assert!(found[1].text.contains("m off the path, rms (allowed 0.010 m)"), "{found:?}");
    // Of all robots of one name the worst counts, and is named.
    let group = TWO.split("[[robots]]").nth(1).unwrap();
    let group =
        format!("[[robots]]{}", group.replace("line.kind", "count = 2\nrow_length = 1\nline.kind"));
    let goal = "[[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"anna\"\npose = [4.0, 0.0, 0.0]\n";
    let found = checks(&[HEAD, &group, goal, &on_path("anna", 0.001)].concat());
    assert!(!found[0].passed && found[0].text.starts_with("anna-000"), "{found:?}");
}

#[test]
fn who_follows_nothing_keeps_to_nothing() {
    let straight = "[[robots]]\nline.kind = \"direct\"\nmind.how.method = \"straight\"\n";
    let on_path = "[[success.on_path]]\nrobot = \"robot\"\n";
    let text = [HEAD, straight, on_path].concat();
    let said = warnings(&text);
    let expected =
        "success.on_path[0]: `robot` has mind.how.method = \"straight\" and follows nothing";
    assert!(said.contains(expected), "{said}");
    let found = checks(&text);
    assert!(!found[0].passed && found[0].text == "the trail was never followed", "{found:?}");
    let unknown = Mission::parse("t.toml", &[HEAD, TWO, on_path].concat(), &[]).unwrap_err();
    let expected = "t.toml:27:9: success.on_path[0].robot = \"robot\": must be one of the mission's names: anna, bert";
    assert_eq!(unknown.to_string(), expected);
}

/// A line that takes everything and answers nothing.
fn silent_robot() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || -> std::io::Result<usize> {
        let (mut stream, _) = listener.accept()?;
        stream.read_to_end(&mut Vec::new())
    });
    address
}

#[test]
fn what_is_not_known_of_a_robot_elsewhere_does_not_hold() {
    let address = silent_robot();
    let head = "[mission]\nname = \"t\"\nduration_max_s = 3.0\n";
    let robot = format!(
        "[[robots]]\nname = \"rover\"\nline = {{ kind = \"tcp\", address = \"{address}\" }}\n\
         mind.how.method = \"straight\"\n"
    );
    let success = "[success]\nno_contact = true\nclearance_min_m = 0.1\n[[success.stayed]]\nrobot = \"rover\"\n";
    let text = [head, &robot, success].concat();
    let found = checks(&text);
    for (name, told) in [
        ("stayed", "not known: rover is elsewhere and not heard"),
        ("clearance", "not known of a robot elsewhere (rover)"),
        ("no contact", "not known of a robot elsewhere (rover)"),
    ] {
        let check = found.iter().find(|check| check.name == name).unwrap();
        assert!(!check.passed && check.text == told, "{check:?}");
    }
    // It is said beforehand, and not of robots that are here.
    let said = warnings(&text);
    for key in ["success.no_contact", "success.clearance_min_m"] {
        assert!(said.contains(&format!("{key}: `rover` is elsewhere")), "{said}");
    }
    let here = "[[robots]]\nname = \"rover\"\nmind.how.method = \"straight\"\n";
    assert!(!warnings(&[head, here, success].concat()).contains("elsewhere"));
    assert!(checks(&[head, here, success].concat()).iter().all(|check| check.passed));
    let nobody = warnings(&[head, "[success]\nno_contact = true\n"].concat());
    assert!(nobody.contains("the mission has no robot, so it cannot fail"), "{nobody}");
}
