//! The two kinds of figure that the reports need: lines over an axis, and lines on a floor.

use geometry::Vec2;
use plotters::{
    coord::Shift,
    prelude::{
        ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, IntoFont, LineSeries,
        PathElement, Polygon, RGBColor, SVGBackend, Text, WHITE,
    },
};

use crate::ExperimentError;

/// Colours that stay apart for colour-blind readers (Okabe and Ito's set, without yellow).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
];

const FONT: &str = "sans-serif";

/// Width of every figure, pixels.
const WIDTH_PX: u32 = 760;
/// Height of the strip above the axes that names the lines; it never covers one.
const LEGEND_PX: u32 = 30;

/// A name in the legend, with the colour and width of its line.
type Entry<'a> = (&'a str, RGBColor, u32);

/// Names the lines in a row.
fn legend(area: &Area<'_>, entries: &[Entry<'_>]) -> Drawn {
    let mut x = 40;
    for &(name, colour, width) in entries {
        let y = LEGEND_PX as i32 / 2;
        area.draw(&PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(width)))?;
        area.draw(&Text::new(name.to_owned(), (x + 31, y - 7), (FONT, 14).into_font()))?;
        // A letter of this size is about 6.5 pixels wide.
        x += 31 + 13 * name.chars().count() as i32 / 2 + 12;
    }
    Ok(())
}

/// A named line.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
    /// Low and high end of an error bar per point; empty for none.
    pub(crate) bars: Vec<[f64; 2]>,
}

/// What an axis says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<'a> {
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
}

/// Lines with markers over a common axis; the y axis begins at 0 unless a line goes below.
pub(crate) fn lines(axes: Axes<'_>, lines: &[Line]) -> Result<String, ExperimentError> {
    let all = || lines.iter().flat_map(|line| &line.points);
    let bars = || lines.iter().flat_map(|line| line.bars.iter().flatten());
    let x = range(all().map(|p| p.0), None);
    let y = range(all().map(|p| p.1).chain(bars().copied()), Some(0.0));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (WIDTH_PX, 440)).into_drawing_area();
        draw_lines(&area, axes, lines, (x, y)).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    Ok(svg)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;
type Span = std::ops::Range<f64>;

fn draw_lines(area: &Area<'_>, axes: Axes<'_>, lines: &[Line], (x, y): (Span, Span)) -> Drawn {
    area.fill(&WHITE)?;
    let bar_step = 0.008 * (x.end - x.start);
    let (top, area) = area.split_vertically(LEGEND_PX);
    let named = |(index, line)| {
        let line: &Line = line;
        (line.name.as_str(), COLOURS[index % COLOURS.len()], 3)
    };
    legend(&top, &lines.iter().enumerate().map(named).collect::<Vec<_>>())?;
    let mut chart = ChartBuilder::on(&area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .max_light_lines(1)
        .light_line_style(RGBColor(242, 242, 242))
        .x_label_formatter(&|v| tick(*v))
        .y_label_formatter(&|v| tick(*v))
        .bold_line_style(RGBColor(224, 224, 224))
        .x_desc(axes.x)
        .y_desc(axes.y)
        .axis_desc_style((FONT, 15).into_font())
        .label_style((FONT, 13).into_font())
        .draw()?;
    let n_beside = lines.len().saturating_sub(1) as f64;
    for (index, line) in lines.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        // Bars stand beside each other; at the same place the last would hide the others.
        let aside = if line.bars.is_empty() { 0.0 } else { index as f64 - 0.5 * n_beside };
        let points = || line.points.iter().map(|&(x, y)| (x + aside * bar_step, y));
        chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
        let dots = points().map(|point| Circle::new(point, 3, colour.filled()));
        // Trajectories have hundreds of points; markers are for measured ones.
        if line.points.len() <= 40 {
            chart.draw_series(dots)?;
        }
        let bars = points().zip(&line.bars);
        chart.draw_series(bars.map(|((x, _), &[low, high])| {
            PathElement::new([(x, low), (x, high)], colour.stroke_width(1))
        }))?;
    }
    Ok(())
}

/// A floor seen from above: outlines, a trail, driven lines. One metre is as long in x as in y.
#[derive(Clone, Debug, Default)]
pub(crate) struct Floor {
    pub(crate) outlines: Vec<Vec<Vec2>>,
    /// What the grey line is.
    pub(crate) trail_name: &'static str,
    pub(crate) trail: Vec<Vec2>,
    pub(crate) driven: Vec<(String, Vec<Vec2>)>,
}

const FLOOR_MARGIN_PX: u32 = 10;
const FLOOR_X_LABELS_PX: u32 = 40;
const FLOOR_Y_LABELS_PX: u32 = 54;
const TRAIL_COLOUR: RGBColor = RGBColor(190, 190, 190);

pub(crate) fn floor(floor: &Floor) -> Result<String, ExperimentError> {
    let points = || {
        let driven = floor.driven.iter().flat_map(|(_, line)| line);
        floor.outlines.iter().flatten().chain(&floor.trail).chain(driven)
    };
    let x = range(points().map(|p| p.x), None);
    let y = range(points().map(|p| p.y), None);
    let (width_m, height_m) = (x.end - x.start, y.end - y.start);
    // The height follows from the width, but a flat or a tall scene stays readable.
    let plot_px = f64::from(WIDTH_PX - 2 * FLOOR_MARGIN_PX - FLOOR_Y_LABELS_PX);
    let height_px = (plot_px * height_m / width_m).clamp(150.0, 620.0).round();
    let scale = plot_px / height_px;
    let missing_m = (scale * height_m - width_m).max(0.0) / 2.0;
    let spare_m = (width_m / scale - height_m).max(0.0) / 2.0;
    let x = x.start - missing_m..x.end + missing_m;
    let y = y.start - spare_m..y.end + spare_m;
    let mut svg = String::new();
    {
        let around_px = 2 * FLOOR_MARGIN_PX + FLOOR_X_LABELS_PX + LEGEND_PX;
        let size = (WIDTH_PX, height_px as u32 + around_px);
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        draw_floor(&area, floor, (x, y)).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    Ok(svg)
}

fn draw_floor(area: &Area<'_>, floor: &Floor, (x, y): (Span, Span)) -> Drawn {
    area.fill(&WHITE)?;
    let (top, area) = area.split_vertically(LEGEND_PX);
    let mut entries: Vec<Entry<'_>> = Vec::new();
    if !floor.trail.is_empty() {
        entries.push((floor.trail_name, TRAIL_COLOUR, 6));
    }
    let named = floor.driven.iter().enumerate().filter(|(_, (name, _))| !name.is_empty());
    entries.extend(named.map(|(i, (name, _))| (name.as_str(), COLOURS[i % COLOURS.len()], 3)));
    legend(&top, &entries)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(FLOOR_MARGIN_PX)
        .x_label_area_size(FLOOR_X_LABELS_PX)
        .y_label_area_size(FLOOR_Y_LABELS_PX)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .max_light_lines(1)
        .light_line_style(RGBColor(246, 246, 246))
        .x_label_formatter(&|v| tick(*v))
        .y_label_formatter(&|v| tick(*v))
        .bold_line_style(RGBColor(228, 228, 228))
        .x_desc("x (m)")
        .y_desc("y (m)")
        .axis_desc_style((FONT, 15).into_font())
        .label_style((FONT, 13).into_font())
        .draw()?;
    let plain = |line: &[Vec2]| line.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>();
    for outline in &floor.outlines {
        chart.draw_series([Polygon::new(plain(outline), RGBColor(190, 180, 165).filled())])?;
    }
    chart.draw_series(LineSeries::new(plain(&floor.trail), TRAIL_COLOUR.stroke_width(6)))?;
    for (index, (_, line)) in floor.driven.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        chart.draw_series(LineSeries::new(plain(line), colour.stroke_width(2)))?;
    }
    Ok(())
}

/// A number at an axis, without digits that say nothing.
fn tick(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The range of finite values with a little room, containing `base` if given; never empty.
fn range(values: impl Iterator<Item = f64>, base: Option<f64>) -> Span {
    let finite = values.filter(|v| v.is_finite()).chain(base);
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let room = if high > low { 0.06 * (high - low) } else { 0.5 };
    let begin = if base == Some(low) { low } else { low - room };
    begin..high + room
}

#[expect(clippy::needless_pass_by_value, reason = "map_err hands over the error")]
fn failed(error: impl ToString) -> ExperimentError {
    ExperimentError::Figure(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_room_and_are_never_empty() {
        assert_eq!(range([].into_iter(), None), 0.0..1.0);
        let one = range([2.0].into_iter(), None);
        assert!(one.start < 2.0 && one.end > 2.0);
        let with_zero = range([5.0, f64::NAN, 10.0].into_iter(), Some(0.0));
        assert!(with_zero.start == 0.0 && with_zero.end > 10.0);
        assert!(range([-1.0].into_iter(), Some(0.0)).start < -1.0);
    }

    #[test]
    fn ticks_are_short() {
        assert_eq!([10.0, 0.5, -0.25, -0.001, 0.0].map(tick), ["10", "0.5", "-0.25", "0", "0"]);
    }

    #[test]
    fn figures_say_what_their_axes_and_lines_are() {
        let line = Line {
            name: "three sets".to_owned(),
            points: vec![(0.1, 2.0), (0.2, 3.0)],
            bars: vec![[1.0, 3.0], [2.0, 4.0]],
        };
        let other = Line { name: "five sets".to_owned(), points: vec![(0.1, 1.0)], bars: vec![] };
        let svg = lines(Axes { x: "period (s)", y: "error (mm)" }, &[line, other]).unwrap();
        for text in ["<svg", "period (s)", "error (mm)", "three sets", "five sets"] {
            assert!(svg.contains(text), "{text} is missing");
        }
    }
}
