//! A report: sections of text, tables and figures, written as one HTML file or as Markdown.

use std::fmt::Write as _;

/// Everything that is to be said about one subject.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The heading.
    pub title: String,
    /// How it was made: mission, seeds, number of runs.
    pub preamble: String,
    /// Its parts.
    pub sections: Vec<Section>,
}

/// One part of a report.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// The heading.
    pub heading: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// Tables, after the text.
    pub tables: Vec<Table>,
    /// Figures, after the tables.
    pub figures: Vec<Figure>,
}

/// A table; every row has as many cells as the head.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Column heads, with units.
    pub head: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

/// A drawing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Figure {
    /// Name of its file, without extension.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The drawing, a whole SVG document.
    pub svg: String,
}

impl Table {
    /// Starts a table without rows.
    pub fn new(caption: &str, head: &[&str]) -> Self {
        let head = head.iter().map(|&cell| cell.to_owned()).collect();
        Self { caption: caption.to_owned(), head, rows: Vec::new() }
    }

    /// The table as comma-separated values, quoted where needed.
    pub fn to_csv(&self) -> String {
        let cell = |text: &String| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text.clone()
            }
        };
        let line =
            |cells: &Vec<String>| cells.iter().map(cell).collect::<Vec<_>>().join(",") + "\n";
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }
}

impl Report {
    /// Every figure, in order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.sections.iter().flat_map(|section| &section.figures)
    }

    /// Every table, in order.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.sections.iter().flat_map(|section| &section.tables)
    }

    /// One self-contained page, figures inside; light and dark.
    pub fn to_html(&self) -> String {
        let mut page = String::new();
        let title = escaped(&self.title);
        page.push_str("<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n");
        page.push_str("<meta name=\"viewport\" content=\"width=device-width\">\n");
        let _infallible = writeln!(page, "<title>{title}</title>\n<style>{STYLE}</style>");
        let _infallible = writeln!(
            page,
            "<h1>{title}</h1>\n<p class=\"preamble\">{}</p>",
            escaped(&self.preamble)
        );
        for section in &self.sections {
            section_html(section, &mut page);
        }
        page.push_str("</html>\n");
        page
    }

    /// The same as Markdown; figures are files beside it, `NAME.svg`.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n", self.title, self.preamble);
        for section in &self.sections {
            let _infallible = write!(text, "\n## {}\n", section.heading);
            for paragraph in &section.text {
                let _infallible = write!(text, "\n{paragraph}\n");
            }
            for table in &section.tables {
                let _infallible = write!(text, "\n{}\n\n", table.caption);
                let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
                text.push_str(&line(&table.head));
                text.push_str(&line(&vec!["---".to_owned(); table.head.len()]));
                text.extend(table.rows.iter().map(|row| line(row)));
            }
            for figure in &section.figures {
                let Figure { name, caption, .. } = figure;
                let _infallible = write!(text, "\n![{caption}]({name}.svg)\n\n*{caption}*\n");
            }
        }
        text
    }
}

fn section_html(section: &Section, page: &mut String) {
    let _infallible = writeln!(page, "<h2>{}</h2>", escaped(&section.heading));
    for paragraph in &section.text {
        let _infallible = writeln!(page, "<p>{}</p>", escaped(paragraph));
    }
    for table in &section.tables {
        let right: Vec<bool> = (0..table.head.len()).map(|i| is_numeric(table, i)).collect();
        let row = |cells: &[String], tag: &str| {
            let cell = |(i, text): (usize, &String)| {
                let class = if right.get(i) == Some(&true) { " class=\"n\"" } else { "" };
                format!("<{tag}{class}>{}</{tag}>", escaped(text))
            };
            format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
        };
        let _infallible = write!(
            page,
            "<div class=\"table\"><table>\n<caption>{}</caption>\n<thead>{}</thead>\n<tbody>\n{}</tbody></table></div>\n",
            escaped(&table.caption),
            row(&table.head, "th"),
            table.rows.iter().map(|cells| row(cells, "td")).collect::<String>()
        );
    }
    for figure in &section.figures {
        // The drawing is our own SVG; only an XML declaration would not be allowed inside a page.
        let svg = figure.svg.trim_start_matches(|c| c != '<');
        let caption = escaped(&figure.caption);
        let _infallible =
            writeln!(page, "<figure>{svg}<figcaption>{caption}</figcaption></figure>");
    }
}

/// Whether a column holds numbers only; what is missing (empty or a dash) may be among them.
fn is_numeric(table: &Table, column: usize) -> bool {
    let cells = || table.rows.iter().filter_map(|row| row.get(column));
    let missing = |cell: &&String| matches!(cell.as_str(), "" | "–");
    let number = |cell: &String| cell.trim_end_matches('°').parse::<f64>().is_ok();
    cells().any(number) && cells().filter(|cell| !missing(cell)).all(number)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

const STYLE: &str = "
:root{color-scheme:light dark;--line:#8886}
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}
h1{font-size:1.6rem;line-height:1.25}h2{font-size:1.2rem;margin-top:2.2rem}
.preamble{opacity:.8}.table{overflow-x:auto}
table{border-collapse:collapse;margin:1rem 0;font-variant-numeric:tabular-nums}
caption{text-align:left;font-weight:600;padding-bottom:.4rem}
th,td{border-bottom:1px solid var(--line);padding:.3rem .8rem .3rem 0;text-align:left;vertical-align:top}
th.n,td.n{text-align:right}
figure{margin:1.2rem 0}figure svg{max-width:100%;height:auto;background:#fff;border-radius:6px}
figcaption{font-size:.9rem;opacity:.8;margin-top:.3rem}";

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::expect;

    fn sample() -> Report {
        let mut table = Table::new("Speeds", &["v (m/s)", "missed"]);
        table.rows.push(vec!["0.3".to_owned(), "1 of 200, < 2 %".to_owned()]);
        let figure = Figure {
            name: "speeds".to_owned(),
            caption: "Missed against speed.".to_owned(),
            svg: "<svg></svg>".to_owned(),
        };
        let section = Section {
            heading: "Speed & sound".to_owned(),
            text: vec!["One paragraph.".to_owned()],
            tables: vec![table],
            figures: vec![figure],
        };
        Report {
            title: "Sample".to_owned(),
            preamble: "Seeds 1 to 2.".to_owned(),
            sections: vec![section],
        }
    }

    #[test]
    fn markdown_reads_like_the_report() {
        expect![[r#"
            # Sample

            Seeds 1 to 2.

            ## Speed & sound

            One paragraph.

            Speeds

            | v (m/s) | missed |
            | --- | --- |
            | 0.3 | 1 of 200, < 2 % |

            ![Missed against speed.](speeds.svg)

            *Missed against speed.*
        "#]]
        .assert_eq(&sample().to_markdown());
    }

    #[test]
    fn html_escapes_text_and_holds_the_figure() {
        let html = sample().to_html();
        assert!(html.contains("<h2>Speed &amp; sound</h2>"));
        assert!(html.contains("<td>1 of 200, &lt; 2 %</td>"));
        assert!(html.contains("<figure><svg></svg>"));
        assert!(
            html.contains("<th class=\"n\">v (m/s)</th><th>missed</th>"),
            "numbers at the right"
        );
    }

    #[test]
    fn csv_quotes_what_needs_it() {
        let report = sample();
        let csv = report.tables().map(Table::to_csv).collect::<String>();
        assert_eq!(csv, "v (m/s),missed\n0.3,\"1 of 200, < 2 %\"\n");
    }
}
