//! The checks. Each takes the repository and answers with findings, one line of prose each.

mod circles;
mod coverage;
mod layers;
mod licences;
mod parts;
mod problems;
mod sources;
mod units;
mod words;

use crate::repository::Repository;

/// A named check.
#[derive(Debug)]
pub(crate) struct Check {
    pub(crate) name: &'static str,
    pub(crate) run: fn(&Repository) -> Vec<String>,
}

/// All checks, in the order in which they are reported.
pub(crate) const CHECKS: &[Check] = &[
    Check { name: "layers of the crates", run: layers::findings },
    Check { name: "circles of files", run: circles::findings },
    Check { name: "names of parts", run: parts::findings },
    Check { name: "heads and lengths of files", run: sources::findings },
    Check { name: "units of public numbers", run: units::findings },
    Check { name: "licences of dependencies", run: licences::findings },
    Check { name: "coverage of the requirements", run: coverage::findings },
    Check { name: "pages of the decision language's codes", run: problems::findings },
    Check { name: "words that must not appear", run: words::findings },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs one check on the repository itself.
    fn check(name: &str) {
        let repository = Repository::read(&crate::root()).unwrap();
        assert!(repository.files.len() > 50, "the repository was not found");
        let check = CHECKS.iter().find(|check| check.name == name).expect("a name in the list");
        let findings = (check.run)(&repository);
        assert!(findings.is_empty(), "{} to mend:\n{}", findings.len(), findings.join("\n"));
    }

    #[test]
    fn crates_depend_downwards() {
        check("layers of the crates");
    }

    #[test]
    fn files_import_no_circles() {
        check("circles of files");
    }

    #[test]
    fn the_loop_and_the_mind_name_no_robot_and_no_protocol() {
        check("names of parts");
    }

    #[test]
    fn files_have_heads_and_fit() {
        check("heads and lengths of files");
    }

    #[test]
    fn public_numbers_say_their_unit() {
        check("units of public numbers");
    }

    #[test]
    fn licences_allow_what_we_do() {
        check("licences of dependencies");
    }

    #[test]
    fn coverage_names_requirements_and_tests_that_exist() {
        check("coverage of the requirements");
    }

    #[test]
    fn every_code_has_its_page() {
        check("pages of the decision language's codes");
    }

    #[test]
    fn no_document_speaks_of_its_making() {
        check("words that must not appear");
    }

    #[test]
    fn every_check_is_tested_here() {
        let here = include_str!("tidy.rs");
        for Check { name, .. } in CHECKS {
            assert!(here.contains(&format!("check(\"{name}\")")), "no test runs `{name}`");
        }
    }
}
