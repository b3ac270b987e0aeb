//! Charts as SVG and reports as HTML or Markdown: one look for everything that Cairn publishes.
//!
//! It knows nothing of what it shows: the caller names axes, lines and captions. Equal input gives equal
//! text, byte by byte.
//!
//! ```
//! use figures::{Axes, Figure, Line, Report, Section, lines};
//!
//! let line = Line { name: "drift".to_owned(), points: vec![(0.0, 0.0), (10.0, 0.4)], ..Line::default() };
//! let svg = lines(Axes { x: "time (s)", y: "error (m)" }, &[line])?;
//! let figure = Figure { name: "drift".to_owned(), caption: "It grows.".to_owned(), svg };
//! let section = Section { heading: "Drift".to_owned(), figures: vec![figure], ..Section::default() };
//! let report = Report { title: "A run".to_owned(), sections: vec![section], ..Report::default() };
//! assert!(report.to_html().contains("<svg"));
//! # Ok::<(), figures::FigureError>(())
//! ```

mod base64;
mod chart;
mod report;

pub use base64::base64;
pub use chart::{Axes, FigureError, Floor, Line, Mark, Picture, floor, lines};
pub use report::{Figure, Report, Section, Table};
