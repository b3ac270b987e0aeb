//! The finished settings of a sweep with their figures, and the best of them.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::plan::{Goal, Setting};

/// One finished setting.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Row {
    /// The setting as overrides, separated by blanks.
    pub setting: String,
    /// Name and value of each figure, each in the unit that its name ends with.
    pub figures: Vec<(String, f64)>,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
    /// How long it took, seconds. The only part that differs from run to run.
    pub time_s: f64,
}

/// All settings in the order of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepTable {
    /// The keys that are varied.
    pub keys: Vec<String>,
    /// Settings with their rows.
    pub rows: Vec<(Setting, Row)>,
}

impl SweepTable {
    /// The index of the best row: the first of those with the best figure; `None` if no row has it.
    pub fn best(&self, goal: &Goal) -> Option<usize> {
        let cost = |row: &Row| {
            let value = row.figures.iter().find(|(name, _)| name == goal.figure())?.1;
            value.is_finite().then(|| goal.cost(value))
        };
        let costs = self.rows.iter().enumerate().filter_map(|(i, (_, row))| Some((i, cost(row)?)));
        costs.min_by(|(i, a), (j, b)| a.total_cmp(b).then(i.cmp(j))).map(|(i, _)| i)
    }

    /// A figure of a row, if it has it.
    pub fn figure(&self, index: usize, name: &str) -> Option<f64> {
        let figures = &self.rows.get(index)?.1.figures;
        figures.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// The indices of all rows, the best first; those without the figure last.
    pub fn order(&self, goal: &Goal) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.rows.len()).collect();
        let cost = |i: usize| self.figure(i, goal.figure()).map_or(f64::INFINITY, |v| goal.cost(v));
        order.sort_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
        order
    }

    /// The names of all figures, in the order in which they first appear.
    pub fn figures(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.rows.iter().flat_map(|(_, row)| &row.figures) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
    }

    /// The table as comma-separated values: the keys, the figures, the failure, and last the time.
    ///
    /// All columns but the last are the same for every repetition of the sweep.
    pub fn to_csv(&self) -> String {
        let quoted = |text: &str| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text.to_owned()
            }
        };
        let figures = self.figures();
        let mut head: Vec<String> = self.keys.iter().map(|k| quoted(k)).collect();
        head.extend(figures.iter().map(|f| quoted(f)));
        head.extend(["failure".to_owned(), "time_s".to_owned()]);
        let mut csv = head.join(",") + "\n";
        for (setting, row) in &self.rows {
            let mut cells: Vec<String> = setting
                .0
                .iter()
                .map(|(_, value)| quoted(value.as_str().unwrap_or(&value.to_string())))
                .collect();
            for figure in &figures {
                let found = row.figures.iter().find(|(name, _)| name == figure);
                cells.push(found.map(|(_, value)| value.to_string()).unwrap_or_default());
            }
            cells.push(quoted(row.failure.as_deref().unwrap_or_default()));
            let _infallible = writeln!(csv, "{},{:.3}", cells.join(","), row.time_s);
        }
        csv
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn table(values: &[Option<f64>]) -> SweepTable {
        let row = |(i, value): (usize, &Option<f64>)| {
            let setting = Setting(vec![("a".to_owned(), toml::Value::Integer(i as i64))]);
            let figures = value.map(|v| ("e_m".to_owned(), v)).into_iter().collect();
            let failure = value.is_none().then(|| "no scans, \"none\"".to_owned());
            let row = Row { setting: setting.name(), figures, failure, time_s: 1.25 };
            (setting, row)
        };
        SweepTable {
            keys: vec!["a".to_owned()],
            rows: values.iter().enumerate().map(row).collect(),
        }
    }

    #[test]
    fn the_first_of_the_best_is_chosen() {
        let table = table(&[Some(2.0), None, Some(1.0), Some(f64::NAN), Some(1.0), Some(3.0)]);
        assert_eq!(table.best(&Goal::Minimise("e_m".into())), Some(2));
        assert_eq!(table.best(&Goal::Maximise("e_m".into())), Some(5));
        assert_eq!(table.best(&Goal::Maximise("f".into())), None);
        assert_eq!(table.order(&Goal::Minimise("e_m".into()))[..4], [2, 4, 0, 5]);
    }

    #[test]
    fn the_table_is_comma_separated() {
        expect![[r#"
            a,e_m,failure,time_s
            0,0.1,,1.250
            1,,"no scans, ""none""",1.250
        "#]]
        .assert_eq(&table(&[Some(0.1), None]).to_csv());
    }
}
