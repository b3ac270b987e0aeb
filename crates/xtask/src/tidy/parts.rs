//! A robot, a sensor, a protocol is a part: whoever runs parts knows none of them by name.

use crate::repository::Repository;

/// Where no part may be named in code: the closed loop, and a robot's mind.
const NAMELESS: &[&str] = &[
    "crates/missions/src/run.rs",
    "crates/missions/src/run/",
    "crates/messages/src/",
    "crates/navigator/src/",
];

/// Names of robots, sensors and protocols, in small letters.
const NAMES: &[&str] = &[
    "pioneer",
    "peoplebot",
    "amigobot",
    "artemic",
    "khepera",
    "create_oi",
    "createdriver",
    "createfirmware",
    "create 2",
    "roomba",
    "arcos",
    "sick",
    "rplidar",
    "ld06",
    "pheromone_link::",
    "ground_link::",
];

pub(super) fn findings(repository: &Repository) -> Vec<String> {
    let mut found = Vec::new();
    for (path, text) in repository.rust_files("crates/") {
        let is_nameless = NAMELESS.iter().any(|place| path.starts_with(place));
        if !is_nameless || path.ends_with("tests.rs") || path.contains("/tests/") {
            continue;
        }
        // What stands in comments and in tests builds nothing.
        let code = (1..).zip(text.lines()).take_while(|(_, line)| line.trim() != "#[cfg(test)]");
        for (number, line) in code.filter(|(_, line)| !line.trim_start().starts_with("//")) {
            let small = line.to_lowercase();
            let named = NAMES.iter().filter(|name| small.contains(*name));
            found.extend(named.map(|name| format!("{path}:{number} names `{name}`")));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    #[test]
    fn names_in_code_are_reported_and_those_in_comments_and_tests_are_not() {
        let repository = Repository::of(&[
            (
                "crates/missions/src/run/line.rs",
                "// As a Pioneer.\nuse wire::ArcosThing;\nlet x = \"rplidar\";\n#[cfg(test)]\nmod tests { sick }",
            ),
            ("crates/missions/src/node/base.rs", "use wire::arcos;"),
            ("crates/navigator/src/mind.rs", "let ok = classic;\nif robot == \"pioneer3dx\" {}"),
        ]);
        expect![[r#"
            crates/missions/src/run/line.rs:2 names `arcos`
            crates/missions/src/run/line.rs:3 names `rplidar`
            crates/navigator/src/mind.rs:2 names `pioneer`"#]]
        .assert_eq(&findings(&repository).join("\n"));
    }
}
