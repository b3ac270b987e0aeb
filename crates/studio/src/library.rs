//! The missions that a page can choose: those that are shipped, and people's own.
//!
//! Own ones come from the command line or from a page, which brings their text. They stay in the list while the program
//! lasts, whatever is shown in between.

use missions::Mission;

use crate::protocol::MissionName;

/// Own missions kept; the oldest is forgotten first.
const N_OWN_MAX: usize = 20;

/// All missions by their names in the list.
#[derive(Debug)]
pub(crate) struct Library {
    shipped: Vec<MissionName>,
    own: Vec<(MissionName, Mission)>,
}

impl Library {
    /// The shipped ones.
    pub(crate) fn shipped() -> Self {
        let shipped = Mission::shipped_infos().into_iter().map(|info| MissionName {
            name: info.name,
            title: info.title,
            about: info.about,
            is_own: false,
        });
        Self { shipped: shipped.collect(), own: Vec::new() }
    }

    /// All, own ones first.
    pub(crate) fn names(&self) -> Vec<MissionName> {
        self.own.iter().map(|(name, _)| name).chain(&self.shipped).cloned().collect()
    }

    /// A mission by its name in the list.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page.
    pub(crate) fn find(&self, name: &str) -> Result<Mission, String> {
        if let Some((_, mission)) = self.own.iter().find(|(own, _)| own.name == name) {
            return Ok(mission.clone());
        }
        // Only shipped names beside: a page must not make the program read files.
        if !self.shipped.iter().any(|shipped| shipped.name == name) {
            return Err(format!("there is no mission `{name}`"));
        }
        Mission::load(name, &[]).map_err(|error| error.to_string())
    }

    /// Puts a mission into the list unless it is a shipped one as it is; its name there. One of the same name that was
    /// brought before is replaced.
    pub(crate) fn keep(&mut self, mission: &Mission) -> String {
        let is_taken = self.shipped.iter().any(|shipped| shipped.name == mission.name());
        if is_taken
            && Mission::load(mission.name(), &[])
                .is_ok_and(|shipped| shipped.to_toml() == mission.to_toml())
        {
            return mission.name().to_owned();
        }
        let own = if is_taken { " (own)" } else { "" };
        let name = MissionName {
            name: format!("{}{own}", mission.name()),
            title: format!("{}{own}", mission.title()),
            about: mission.about().to_owned(),
            is_own: true,
        };
        self.own.retain(|(kept, _)| kept.name != name.name);
        self.own.insert(0, (name.clone(), mission.clone()));
        self.own.truncate(N_OWN_MAX);
        name.name
    }
}

/// Reads a mission that a page brought. The files that it names are looked for among the shipped ones only.
///
/// # Errors
///
/// A sentence for the person at the page, with the line where the reader knows it.
pub(crate) fn read(file: &str, text: &str) -> Result<Mission, String> {
    let mission = Mission::parse(file, text, &[]).map_err(|error| error.to_string())?;
    if mission.has_real_robot() {
        return Err(format!(
            "{file}: a robot of it is elsewhere, and a page may not connect the program to anything; \
             give the file to the program: cairn run {file}"
        ));
    }
    Ok(mission)
}

/// Why a file of `bytes` bytes that begins with `head` is no mission that a page may bring.
pub(crate) fn too_large(file: &str, head: &[u8], bytes: u64, bytes_max: usize) -> String {
    match files::Sort::of(file.as_ref(), head) {
        Some(sort) if sort != files::Sort::MISSION => format!("{file} is no mission: it is {sort}"),
        _ => format!(
            "{file} has {} kB; a mission that a page brings has at most {}: give it to the program: cairn run {file}",
            bytes.div_ceil(1024),
            bytes_max / 1024
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_mission_is_named() {
        for (file, text, word) in [
            ("typo.rdpl", "ADN O0,I0\n", "cairn rdpl"),
            ("mine.toml", "AND O0,I0,1L,1L,1L\n", "cairn rdpl"),
            ("a.json", "{\"a\": 1}", "JSON"),
            ("mine.toml", "[mission]\rname = \"x\"\r", "carriage return"),
        ] {
            let said = read(file, text).unwrap_err();
            assert!(said.starts_with(file) && said.contains(word), "{said}");
        }
        let said = too_large("out.mcap", b"\x89MCAP0\r\n", 3 << 20, 1 << 18);
        assert!(said.contains("cairn replay") && !said.contains("kB"), "{said}");
        let said = too_large("mine.toml", b"[mission]\n", 3 << 20, 1 << 18);
        assert!(said.contains("3072 kB") && said.contains("256"), "{said}");
    }

    fn own(name: &str, title: &str) -> Mission {
        let text = format!(
            "[mission]\nname = \"{name}\"\ntitle = \"{title}\"\nduration_max_s = 5.0\n\
             [world]\nbounds_m = [-1.0, -1.0, 1.0, 1.0]\n[[robots]]\nname = \"robot\"\n\
             [robots.mind]\nhow.method = \"straight\"\n"
        );
        read("mine.toml", &text).unwrap()
    }

    #[test]
    fn own_missions_stay_and_shipped_ones_are_not_doubled() {
        let mut library = Library::shipped();
        let n_shipped = library.names().len();
        assert_eq!(library.keep(&Mission::load("doorbell", &[]).unwrap()), "doorbell");
        assert_eq!(library.names().len(), n_shipped);
        assert_eq!(library.keep(&own("mine", "First")), "mine");
        assert_eq!(library.keep(&own("mine", "Second")), "mine");
        assert_eq!(library.keep(&own("doorbell", "Another")), "doorbell (own)");
        let names = library.names();
        let mine: Vec<_> = names.iter().filter(|n| n.is_own).map(|n| &*n.title).collect();
        assert_eq!(mine, ["Another (own)", "Second"]);
        assert_eq!(library.find("mine").unwrap().title(), "Second");
        assert_eq!(library.find("doorbell (own)").unwrap().title(), "Another");
        assert_ne!(library.find("doorbell").unwrap().title(), "Another");
        for name in ["nowhere", "../missions/doorbell.toml", "/etc/passwd"] {
            assert!(library.find(name).unwrap_err().contains("no mission"), "{name}");
        }
        for i in 0..30 {
            library.keep(&own(&format!("own-{i}"), "x"));
        }
        assert_eq!(library.names().len(), n_shipped + N_OWN_MAX);
    }

    #[test]
    fn what_a_page_brings_reads_no_files_and_connects_to_nothing() {
        let elsewhere = "[mission]\nname = \"x\"\nduration_max_s = 5.0\n\
             [world]\nbounds_m = [-1.0, -1.0, 1.0, 1.0]\n[[robots]]\nname = \"robot\"\n\
             [robots.mind]\nhow.method = \"straight\"\n[robots.line]\nkind = \"tcp\"\naddress = \"127.0.0.1:9\"\n";
        assert!(read("x.toml", elsewhere).unwrap_err().contains("cairn run x.toml"));
        // A file of this repository, which a mission from a file of one's own could name.
        let names_a_file = format!(
            "[mission]\nname = \"x\"\n[world]\nmap = {:?}\n",
            concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")
        );
        let refused = read("x.toml", &names_a_file).unwrap_err();
        assert!(refused.contains("world.map") && !refused.contains("2D-Map"), "{refused}");
        let wrong = read("x.toml", "[mission]\nname = \"x\"\nfoo = 1\n").unwrap_err();
        assert!(wrong.contains("x.toml") && wrong.contains("line 3"), "{wrong}");
    }
}
