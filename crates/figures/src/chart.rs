//! The two kinds of figure that the reports need: lines over an axis, and lines on a floor.

use std::fmt::Write as _;

use geometry::Vec2;
use plotters::{
    coord::Shift,
    prelude::{
        ChartBuilder, Circle, Color, DrawingArea, IntoDrawingArea, IntoFont, LineSeries,
        PathElement, Polygon, RGBColor, SVGBackend, Text, WHITE,
    },
};

use crate::base64;

/// A figure that cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a figure cannot be drawn: {0}")]
pub struct FigureError(pub String);

/// A named line.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// What the legend says; empty for no entry.
    pub name: String,
    /// Where it runs; what is not finite is left out.
    pub points: Vec<(f64, f64)>,
    /// Low and high end of an error bar for each point; empty for none.
    pub bars: Vec<[f64; 2]>,
    /// How the points are drawn.
    pub mark: Mark,
}

/// How the points of a line are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// Joined; up to forty of them with a dot each.
    #[default]
    Joined,
    /// Dots, for things that happen at times of their own.
    Dots,
}

/// What an axis says, with its unit.
#[derive(Clone, Copy, Debug)]
pub struct Axes<'a> {
    /// Below.
    pub x: &'a str,
    /// At the left.
    pub y: &'a str,
}

/// A floor seen from above. One metre is as long in x as in y.
#[derive(Clone, Debug, Default)]
pub struct Floor {
    /// A picture under everything else.
    pub picture: Option<Picture>,
    /// Things that stand there, metres.
    pub outlines: Vec<Vec<Vec2>>,
    /// What the broad grey line is.
    pub trail_name: &'static str,
    /// The broad grey line, metres.
    pub trail: Vec<Vec2>,
    /// Thin lines with their names, metres.
    pub driven: Vec<(String, Vec<Vec2>)>,
    /// What the links are.
    pub links_name: &'static str,
    /// Pairs of places that belong together, metres.
    pub links: Vec<[Vec2; 2]>,
}

/// A picture that lies on the floor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// A whole PNG file.
    pub png: Vec<u8>,
    /// Its lower left corner, metres.
    pub low: Vec2,
    /// Its upper right corner, metres.
    pub high: Vec2,
}

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
const LINK_COLOUR: RGBColor = RGBColor(204, 121, 167);

const LINK_OPACITY: f64 = 0.35;

const FONT: &str = "sans-serif";

/// Width of every figure, pixels.
const WIDTH_PX: u32 = 760;
/// Height of the strip above the axes that names the lines; it never covers one.
const LEGEND_PX: u32 = 30;
/// Height of a floor's plot at most, pixels, without and with a picture.
const FLOOR_HEIGHT_MAX_PX: [f64; 2] = [620.0, 900.0];

/// A name in the legend, with the colour and width of its line.
type Entry<'a> = (&'a str, RGBColor, u32);

/// Lines with markers over a common axis, as SVG; the y axis begins at 0 unless a line goes below.
///
/// # Errors
///
/// [`FigureError`] when the drawing library refuses.
pub fn lines(axes: Axes<'_>, lines: &[Line]) -> Result<String, FigureError> {
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

/// A floor with its lines, as SVG.
///
/// # Errors
///
/// [`FigureError`] when the drawing library refuses.
pub fn floor(floor: &Floor) -> Result<String, FigureError> {
    let points = || {
        let driven = floor.driven.iter().flat_map(|(_, line)| line);
        let ends = floor.links.iter().flatten();
        floor.outlines.iter().flatten().chain(&floor.trail).chain(driven).chain(ends)
    };
    let corners = || floor.picture.iter().flat_map(|picture| [picture.low, picture.high]);
    let x = range(points().map(|p| p.x).chain(corners().map(|p| p.x)), None);
    let y = range(points().map(|p| p.y).chain(corners().map(|p| p.y)), None);
    let (width_m, height_m) = (x.end - x.start, y.end - y.start);
    // The height follows from the width, but a flat or a tall scene stays readable.
    let plot_px = f64::from(WIDTH_PX - 2 * FLOOR_MARGIN_PX - FLOOR_Y_LABELS_PX);
    let height_max_px = FLOOR_HEIGHT_MAX_PX[usize::from(floor.picture.is_some())];
    let height_px = (plot_px * height_m / width_m).clamp(150.0, height_max_px).round();
    let scale = plot_px / height_px;
    let missing_m = (scale * height_m - width_m).max(0.0) / 2.0;
    let spare_m = (width_m / scale - height_m).max(0.0) / 2.0;
    let x = x.start - missing_m..x.end + missing_m;
    let y = y.start - spare_m..y.end + spare_m;
    let mut svg = String::new();
    let mut place = None;
    {
        let around_px = 2 * FLOOR_MARGIN_PX + FLOOR_X_LABELS_PX + LEGEND_PX;
        let size = (WIDTH_PX, height_px as u32 + around_px);
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        draw_floor(&area, floor, (x, y), &mut place).map_err(failed)?;
        area.present().map_err(failed)?;
    }
    if let (Some(picture), Some(place)) = (&floor.picture, place) {
        lay_under(&mut svg, picture, place);
    }
    Ok(svg)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;
type Span = std::ops::Range<f64>;
/// Upper left and lower right corner, pixels.
type Place = [(i32, i32); 2];

/// Names the lines in a row.
fn legend(area: &Area<'_>, entries: &[Entry<'_>]) -> Drawn {
    let mut x = 40;
    for &(name, colour, width) in entries.iter().filter(|(name, ..)| !name.is_empty()) {
        let y = LEGEND_PX as i32 / 2;
        area.draw(&PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(width)))?;
        area.draw(&Text::new(name.to_owned(), (x + 31, y - 7), (FONT, 14).into_font()))?;
        // A letter of this size is about 6.5 pixels wide.
        x += 31 + 13 * name.chars().count() as i32 / 2 + 12;
    }
    Ok(())
}

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
        let finite = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        let points = || line.points.iter().map(|&(x, y)| (x + aside * bar_step, y));
        if line.mark == Mark::Joined {
            let style = colour.stroke_width(2);
            chart.draw_series(LineSeries::new(points().filter(finite), style))?;
        }
        let dots = points().filter(finite).map(|point| Circle::new(point, 3, colour.filled()));
        // Trajectories have hundreds of points; markers are for measured ones.
        if line.points.len() <= 40 || line.mark == Mark::Dots {
            chart.draw_series(dots)?;
        }
        let bars = points().zip(&line.bars);
        chart.draw_series(bars.map(|((x, _), &[low, high])| {
            PathElement::new([(x, low), (x, high)], colour.stroke_width(1))
        }))?;
    }
    Ok(())
}

const FLOOR_MARGIN_PX: u32 = 10;
const FLOOR_X_LABELS_PX: u32 = 40;
const FLOOR_Y_LABELS_PX: u32 = 54;
const TRAIL_COLOUR: RGBColor = RGBColor(190, 190, 190);

fn draw_floor(
    area: &Area<'_>,
    floor: &Floor,
    (x, y): (Span, Span),
    place: &mut Option<Place>,
) -> Drawn {
    area.fill(&WHITE)?;
    let (top, area) = area.split_vertically(LEGEND_PX);
    let mut entries: Vec<Entry<'_>> = Vec::new();
    if !floor.trail.is_empty() {
        entries.push((floor.trail_name, TRAIL_COLOUR, 6));
    }
    for (index, (name, _)) in floor.driven.iter().enumerate() {
        entries.push((name, COLOURS[index % COLOURS.len()], 3));
    }
    if !floor.links.is_empty() {
        entries.push((floor.links_name, LINK_COLOUR, 2));
    }
    legend(&top, &entries)?;
    let mut chart = ChartBuilder::on(&area)
        .margin(FLOOR_MARGIN_PX)
        .x_label_area_size(FLOOR_X_LABELS_PX)
        .y_label_area_size(FLOOR_Y_LABELS_PX)
        .build_cartesian_2d(x, y)?;
    let mut mesh = chart.configure_mesh();
    mesh.max_light_lines(1)
        .light_line_style(RGBColor(246, 246, 246))
        .x_label_formatter(&|v| tick(*v))
        .y_label_formatter(&|v| tick(*v))
        .bold_line_style(RGBColor(228, 228, 228))
        .x_desc("x (m)")
        .y_desc("y (m)")
        .axis_desc_style((FONT, 15).into_font())
        .label_style((FONT, 13).into_font());
    // Lines of the mesh would look like walls.
    if floor.picture.is_some() {
        mesh.disable_mesh();
    }
    mesh.draw()?;
    *place = floor.picture.as_ref().map(|picture| {
        let (low, high) = (picture.low, picture.high);
        [chart.backend_coord(&(low.x, high.y)), chart.backend_coord(&(high.x, low.y))]
    });
    let plain = |line: &[Vec2]| line.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>();
    for outline in &floor.outlines {
        chart.draw_series([Polygon::new(plain(outline), RGBColor(190, 180, 165).filled())])?;
    }
    chart.draw_series(LineSeries::new(plain(&floor.trail), TRAIL_COLOUR.stroke_width(6)))?;
    // Many links lie over each other; what is below them stays to be seen.
    let faint = LINK_COLOUR.mix(LINK_OPACITY);
    let link = |ends: &[Vec2; 2]| PathElement::new(plain(ends), faint.stroke_width(1));
    chart.draw_series(floor.links.iter().map(link))?;
    for (index, (_, line)) in floor.driven.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let width = if floor.picture.is_some() { 1 } else { 2 };
        chart.draw_series(LineSeries::new(plain(line), colour.stroke_width(width)))?;
    }
    Ok(())
}

/// Puts a picture above the white ground and below everything that is drawn.
fn lay_under(svg: &mut String, picture: &Picture, [(left, top), (right, bottom)]: Place) {
    let (width, height) = ((right - left).max(1), (bottom - top).max(1));
    let mut image = format!(
        "<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" \
         preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
         href=\"data:image/png;base64,"
    );
    let _infallible = writeln!(image, "{}\"/>", base64::base64(&picture.png));
    // The ground is the first thing drawn: a rectangle that is closed by the first `/>`.
    let ground = svg.find("/>").map_or(0, |at| at + 2);
    svg.insert_str(ground, &image);
}

/// A number at an axis, without digits that say nothing.
fn tick(value: f64) -> String {
    let digits = match value.abs() {
        size if size < 0.02 => 4,
        size if size < 0.5 => 3,
        _ => 2,
    };
    let text = format!("{value:.digits$}");
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
fn failed(error: impl ToString) -> FigureError {
    FigureError(error.to_string())
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
        assert_eq!([10.0, 0.5, -0.25, -0.00001, 0.0].map(tick), ["10", "0.5", "-0.25", "0", "0"]);
        assert_eq!([0.0035, 0.035].map(tick), ["0.0035", "0.035"]);
    }

    #[test]
    fn figures_say_what_their_axes_and_lines_are() {
        let line = Line {
            name: "three sets".to_owned(),
            points: vec![(0.1, 2.0), (0.2, 3.0)],
            bars: vec![[1.0, 3.0], [2.0, 4.0]],
            ..Line::default()
        };
        let other = Line {
            name: "five sets".to_owned(),
            points: vec![(0.1, 1.0), (f64::NAN, 2.0)],
            mark: Mark::Dots,
            ..Line::default()
        };
        let svg = lines(Axes { x: "period (s)", y: "error (mm)" }, &[line, other]).unwrap();
        for text in ["<svg", "period (s)", "error (mm)", "three sets", "five sets"] {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert_eq!(svg.matches("<circle").count(), 3, "one dot for each finite point");
    }

    /// Pixels are read back from the drawing: a picture of 10 m × 5 m must cover what a line along its
    /// edges covers.
    #[test]
    fn a_picture_lies_where_its_corners_are() {
        let (low, high) = (Vec2::new(-2.0, 1.0), Vec2::new(8.0, 6.0));
        let edge = vec![low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        let scene = Floor {
            picture: Some(Picture { png: vec![1, 2, 3], low, high }),
            driven: vec![("edge".to_owned(), edge)],
            links_name: "closures",
            links: vec![[low, high]],
            ..Floor::default()
        };
        let svg = floor(&scene).unwrap();
        let image = svg.split("<image ").nth(1).unwrap();
        let number = |name: &str| -> f64 {
            let rest = image.split(&format!("{name}=\"")).nth(1).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        assert!(image.contains("base64,AQID\""));
        assert!((number("width") / number("height") - 2.0).abs() < 0.02, "a metre is a metre");
        let corner = format!("{},{}", number("x"), number("y") + number("height"));
        assert!(svg.contains(&corner), "no line begins at {corner}");
        assert!(svg.find("<image").unwrap() < svg.find("<polyline").unwrap(), "it lies below");
        assert!(svg.contains("closures"));
    }
}
