//! The frame of a map: ticks with coordinates along its border, and a line around the sheet. All of it consists of pen
//! strokes, for raster and vector output.
//!
//! The border itself is that of the style's paper. Ticks are where a line of equal easting, northing, longitude or
//! latitude crosses it; in a projection such lines are curved, so that each side is searched for its own crossings.
//! Lengths here are pixels of the style, which are scaled with the dots per inch.

use glam::DVec2;
use kurbo::Affine;

use super::title::{PEN, grouped};
use crate::file::svg::Text;
use crate::lettering::Line;
use crate::lettering::area::Area;
use crate::lettering::ink::PenStroke;
use crate::style::{Color, Paper};

/// Width of the margin, which has the coordinates.
const MARGIN: f64 = 30.0;
/// Width of the border of a paper that has none.
const BORDER: f64 = 1.2;
/// Distance of the outer line from the edge of the sheet, and its width.
const OUTER: [f64; 2] = [9.0, 2.0];
/// Length and width of a tick, which points into the map.
const TICK: [f64; 2] = [7.0, 1.0];
/// Height of capitals of coordinates, the distance from the border, and the width of the pen.
const LETTERS: f64 = 6.5;
const GAP: f64 = 4.0;
const LETTERS_PEN: f64 = 1.0;
/// Least distance between ticks.
const SPACING: f64 = 90.0;
/// Half a turn in seconds of arc: neither east nor west.
const HALF_TURN_SECONDS: u64 = 648_000;
/// Points at which the coordinates along a side are computed.
const POINTS: usize = 65;
/// Steps between ticks of longitude and latitude, in seconds of arc.
const STEPS_SECONDS: [f64; 20] = [
    1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0, 7200.0, 18_000.0, 36_000.0,
    54_000.0, 108_000.0, 162_000.0, 324_000.0,
];

/// The coordinates that a frame states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinates {
    /// Longitude and latitude in degrees.
    Degrees,
    /// Easting and northing in the unit of a projection.
    Lengths,
}

/// Sets the margin and the border of a framed map on a paper; `px` is the number of pixels per pixel of the style.
pub(crate) fn set_paper(paper: &mut Paper, ink: Color, px: f64) {
    paper.margin_px = paper.margin_px.max((MARGIN * px).round() as f32);
    if paper.border_px == 0.0 {
        (paper.border_px, paper.border) = ((BORDER * px) as f32, ink);
    }
}

/// Returns the width of the edge of a framed picture that is not part of the map, in pixels.
pub(crate) fn edge_px(paper: &Paper) -> u32 {
    (paper.margin_px + paper.border_px).ceil() as u32
}

/// A crossing of a side of the border with a line of equal coordinates.
#[derive(Clone, Debug, PartialEq)]
struct Crossing {
    /// Place on the side, from 0 at its beginning to 1 at its end.
    at: f64,
    label: String,
}

/// The frame of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MapFrame {
    /// Strokes in pixels of the picture.
    pub strokes: Vec<PenStroke>,
    /// Letters of fonts, in pixels of the picture.
    pub areas: Vec<Area>,
    /// The words of the labels, in pixels of the picture.
    pub texts: Vec<Text>,
    /// The number of coordinates that are stated.
    pub labels: usize,
}

/// Returns the frame of a map. `coordinates` are those of a point of the picture in pixels.
pub(crate) fn map_frame(
    size_px: [u32; 2],
    paper: &Paper,
    kind: Coordinates,
    coordinates: impl Fn(DVec2) -> DVec2,
    px: f64,
) -> MapFrame {
    let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
    let outer = outline(DVec2::splat(OUTER[0] * px), size - OUTER[0] * px, OUTER[1] * px);
    let mut frame = MapFrame { strokes: vec![outer], ..MapFrame::default() };
    let middle = f64::from(paper.margin_px) + 0.5 * f64::from(paper.border_px);
    let low = DVec2::splat(middle);
    let high = size - middle - DVec2::new(0.0, f64::from(paper.foot_px));
    if (high - low).min_element() < SPACING * px {
        return frame;
    }
    let corner = |x: f64, y: f64| DVec2::new(x, y);
    // Begin, end, the axis of the coordinate, and the direction into the map.
    let sides = [
        (low, corner(high.x, low.y), 0, DVec2::Y),
        (corner(low.x, high.y), high, 0, DVec2::NEG_Y),
        (corner(low.x, high.y), low, 1, DVec2::X),
        (high, corner(high.x, low.y), 1, DVec2::NEG_X),
    ];
    let along = |from: DVec2, to: DVec2, axis: usize| -> Vec<f64> {
        let part = |i: usize| i as f64 / (POINTS - 1) as f64;
        unwrapped((0..POINTS).map(|i| coordinates(from.lerp(to, part(i)))[axis]).collect(), kind)
    };
    let all = sides.map(|(from, to, axis, _)| along(from, to, axis));
    // Opposite sides have the same step, so that their ticks belong together.
    let least = |axis: usize| {
        let of_axis = all.iter().zip(&sides).filter(|(_, side)| side.2 == axis);
        let needed = |(values, (from, to, ..)): (&Vec<f64>, &(DVec2, DVec2, usize, DVec2))| {
            let span = values.last().zip(values.first()).map_or(0.0, |(last, first)| (last - first).abs());
            span * SPACING * px / from.distance(*to)
        };
        of_axis.map(needed).fold(0.0, f64::max)
    };
    let steps = [0, 1].map(|axis| step(least(axis), kind));
    for (values, (from, to, axis, inward)) in all.iter().zip(sides) {
        let Some(step) = steps[axis] else { continue };
        for crossing in crossings(values, step, kind, axis) {
            let at = from.lerp(to, crossing.at);
            frame.strokes.push(PenStroke::line(at, at + inward * TICK[0] * px, TICK[1] * px));
            let (strokes, areas, text) = label(&crossing.label, at, inward, [low, high], paper, px);
            frame.labels += usize::from(!strokes.is_empty() || !areas.is_empty());
            frame.strokes.extend(strokes);
            frame.areas.extend(areas);
            frame.texts.extend(text);
        }
    }
    frame
}

fn outline(low: DVec2, high: DVec2, width_px: f64) -> PenStroke {
    let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y), low];
    PenStroke { points: corners.to_vec(), width_px }
}

/// Returns longitudes without the jump at the date line.
fn unwrapped(mut values: Vec<f64>, kind: Coordinates) -> Vec<f64> {
    if kind == Coordinates::Degrees {
        for i in 1..values.len() {
            values[i] -= 360.0 * ((values[i] - values[i - 1]) / 360.0).round();
        }
    }
    values
}

/// Returns the smallest round step that is at least `least`; `None` if the side is too short for two ticks of a globe, or
/// has a single coordinate.
fn step(least: f64, kind: Coordinates) -> Option<f64> {
    if !(least.is_finite() && least > 0.0) {
        return None;
    }
    match kind {
        Coordinates::Degrees => STEPS_SECONDS.into_iter().map(|step| step / 3600.0).find(|step| *step >= least),
        Coordinates::Lengths => Some(least_of(&[1.0, 2.0, 5.0, 10.0], least)),
    }
}

/// Returns the smallest of some multiples of powers of ten that is at least a number. The multiples are from 1 to 10.
fn least_of(multiples: &[f64], number: f64) -> f64 {
    let power = 10.0_f64.powf(number.log10().floor());
    let mut round = multiples.iter().map(|multiple| multiple * power);
    round.find(|round| *round >= number * (1.0 - 1e-9)).unwrap_or(number)
}

fn crossings(values: &[f64], step: f64, kind: Coordinates, axis: usize) -> Vec<Crossing> {
    let mut found = Vec::new();
    for (i, pair) in values.windows(2).enumerate() {
        let [low, high] = [pair[0].min(pair[1]), pair[0].max(pair[1])];
        if !(low.is_finite() && high > low) {
            continue;
        }
        let first = (low / step).ceil() as i64;
        for number in first.. {
            let value = number as f64 * step;
            // The end of a segment is the beginning of the next one.
            if value >= high {
                break;
            }
            // The plane of a map of the world goes on beyond the poles.
            if kind == Coordinates::Degrees && axis == 1 && value.abs() > 90.0 {
                continue;
            }
            let within = (value - pair[0]) / (pair[1] - pair[0]);
            let at = (i as f64 + within) / (values.len() - 1) as f64;
            found.push(Crossing { at, label: text(value, step, kind, axis) });
        }
    }
    found
}

/// Returns a coordinate as text: `46°30′N`, or `2 600 000`.
fn text(value: f64, step: f64, kind: Coordinates, axis: usize) -> String {
    if kind == Coordinates::Lengths {
        let decimals = (-(step + 1e-12).log10().floor()).max(0.0) as usize;
        let sign = if value <= -0.5 * step { "−" } else { "" };
        let text = format!("{:.decimals$}", value.abs());
        let (whole, part) =
            text.split_once('.').map_or((&*text, String::new()), |(whole, part)| (whole, format!(".{part}")));
        return format!("{sign}{}{part}", grouped(whole.parse().unwrap_or(0.0)));
    }
    let value = if axis == 0 { (value + 180.0).rem_euclid(360.0) - 180.0 } else { value };
    let seconds = (value.abs() * 3600.0).round() as u64;
    let side = match (axis, seconds, value < 0.0) {
        (_, 0, _) | (0, HALF_TURN_SECONDS, _) => "",
        (0, _, true) => "W",
        (0, _, false) => "E",
        (_, _, true) => "S",
        (_, _, false) => "N",
    };
    let (degrees, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if step >= 1.0 {
        format!("{degrees}°{side}")
    } else if step * 60.0 > 1.0 - 1e-9 {
        format!("{degrees}°{minutes:02}′{side}")
    } else {
        format!("{degrees}°{minutes:02}′{seconds:02}″{side}")
    }
}

/// Returns the strokes, the areas and the words of a label outside of the border, in its middle at `at`; on the left and right sides it is read
/// upward. A label that would go beyond a corner is left out.
fn label(
    text: &str,
    at: DVec2,
    inward: DVec2,
    [low, high]: [DVec2; 2],
    paper: &Paper,
    px: f64,
) -> (Vec<PenStroke>, Vec<Area>, Option<Text>) {
    let line = Line::small(text, paper.typeface);
    let height = LETTERS * px;
    let half = 0.5 * line.width() * height;
    let is_upright = inward.x == 0.0;
    let room = if is_upright { (at.x - low.x).min(high.x - at.x) } else { (at.y - low.y).min(high.y - at.y) };
    if room < half {
        return (Vec::new(), Vec::new(), None);
    }
    let outside = 0.5 * f64::from(paper.border_px) + GAP * px;
    // The tops of letters point up or to the left.
    let is_below = inward == DVec2::NEG_Y || inward == DVec2::NEG_X;
    let down = if is_upright { DVec2::Y } else { DVec2::X };
    let forward = if is_upright { DVec2::X } else { DVec2::NEG_Y };
    let baseline = at - inward * outside + if is_below { down * height } else { DVec2::ZERO };
    let begin = baseline - forward * half;
    let turned = |point: DVec2| begin + forward * point.x + down * point.y;
    let letters = line.strokes(DVec2::ZERO, height);
    let width_px = (PEN * height).max(LETTERS_PEN * px);
    let strokes =
        letters.into_iter().map(|points| PenStroke { points: points.into_iter().map(turned).collect(), width_px });
    let turn = Affine::new([forward.x, forward.y, down.x, down.y, begin.x, begin.y]);
    let areas = line.areas(DVec2::ZERO, height).into_iter().map(|area| Area::new(turn * area.curves, area.pen_px));
    let text = line.words(DVec2::ZERO, height).map(|text| text.placed(turn));
    (strokes.collect(), areas.collect(), text)
}

/// Returns the smallest round denominator of a scale that is at least `exact`.
pub(crate) fn round_scale(exact: f64) -> f64 {
    least_of(&[1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5, 10.0], exact)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    fn paper() -> Paper {
        let mut paper = crate::style::Style::load("plain").unwrap().paper;
        paper.typeface = crate::style::Typeface::Strokes;
        (paper.margin_px, paper.border_px, paper.foot_px) = (0.0, 0.0, 40.0);
        set_paper(&mut paper, Color::default(), 1.0);
        paper
    }

    #[test]
    fn scales_are_round() {
        let found = [866_000.0, 1_000_000.0, 87_600.0, 24_000.0, 10.1, 6.2].map(round_scale);
        assert_eq!(found, [1_000_000.0, 1_000_000.0, 100_000.0, 25_000.0, 12.5, 7.5]);
    }

    #[test]
    fn steps_are_round_and_have_room() {
        let lengths = [0.3, 1.0, 1.1, 2.1, 4.9, 777.0].map(|least| step(least, Coordinates::Lengths).unwrap());
        assert_eq!(lengths.map(|step| (step * 10.0).round() / 10.0), [0.5, 1.0, 2.0, 5.0, 5.0, 1000.0]);
        let degrees = [0.0001, 0.2, 0.4, 1.5, 29.0].map(|least| step(least, Coordinates::Degrees).unwrap() * 3600.0);
        assert_eq!(degrees.map(f64::round), [1.0, 900.0, 1800.0, 7200.0, 108_000.0]);
        assert_eq!([step(91.0, Coordinates::Degrees), step(0.0, Coordinates::Lengths)], [None, None]);
    }

    #[test]
    fn coordinates_are_written_as_on_maps() {
        let degrees = |value, step, axis| text(value, step, Coordinates::Degrees, axis);
        assert_eq!(degrees(46.5, 0.25, 1), "46°30′N");
        assert_eq!(degrees(-8.0, 1.0, 0), "8°W");
        assert_eq!(degrees(190.0, 1.0, 0), "170°W");
        assert_eq!([degrees(180.0, 30.0, 0), degrees(-180.0, 30.0, 0), degrees(540.0, 30.0, 0)], ["180°"; 3]);
        assert_eq!(degrees(46.999_999_99, 1.0 / 60.0, 1), "47°00′N");
        let length = |value, step| text(value, step, Coordinates::Lengths, 0);
        assert_eq!([length(-0.05, 0.05), length(0.0, 0.05), length(1234.5, 0.5)], ["−0.05", "0.00", "1\u{2009}234.5"]);
        assert_eq!([length(-2000.0, 1000.0), length(0.0, 1.0)], ["−2\u{2009}000", "0"]);
        assert_eq!(degrees(-0.002_777_8, 1.0 / 360.0, 1), "0°00′10″S");
        assert_eq!(text(2_600_000.0, 1000.0, Coordinates::Lengths, 0), "2\u{2009}600\u{2009}000");
    }

    #[test]
    fn ticks_are_at_their_coordinates() {
        // A projection whose lines of equal coordinates are curved.
        let coordinates =
            |px: DVec2| DVec2::new(8.0 + px.x * 1e-3 + px.y * px.y * 2e-8, 47.0 - px.y * 1e-3 + px.x * 1e-5);
        let size = [700, 500];
        let paper = paper();
        let MapFrame { strokes: drawn, labels, .. } = map_frame(size, &paper, Coordinates::Degrees, coordinates, 1.0);
        let ticks: Vec<&PenStroke> = drawn
            .iter()
            .filter(|stroke| stroke.points.len() == 2 && stroke.points[0].distance(stroke.points[1]) == TICK[0])
            .collect();
        assert!(ticks.len() >= 8, "{}", ticks.len());
        // Ten minutes of longitude, and of latitude.
        let step = 1.0 / 6.0;
        let off = |value: f64| (value / step - (value / step).round()).abs() * step;
        let found = |tick: &&PenStroke, axis: usize| off(coordinates(tick.points[0])[axis]);
        for tick in &ticks {
            let axis = usize::from(tick.points[0].y == tick.points[1].y);
            assert!(found(tick, axis) < 1e-5, "{tick:?}");
            // Planted: the other coordinate is not round there.
            assert!(found(tick, 1 - axis) > 1e-4, "{tick:?}");
        }
        // Everything stays on the margin, except for the ticks.
        let middle = f64::from(paper.margin_px) + 0.5 * f64::from(paper.border_px);
        let [right, bottom] = [700.0 - middle, 500.0 - middle - f64::from(paper.foot_px)];
        let is_on_map = |at: &DVec2| at.x > middle && at.x < right && at.y > middle && at.y < bottom;
        let letters = drawn.iter().filter(|stroke| !ticks.contains(stroke));
        let outer = |at: &DVec2| at.min(DVec2::new(700.0, 500.0) - *at).min_element();
        let points: Vec<&DVec2> = letters.flat_map(|stroke| &stroke.points).collect();
        assert!(points.iter().all(|at| !is_on_map(at) && outer(at) >= OUTER[0]), "letters cross a line");
        // Labels in the middle of their ticks; those at corners are left out.
        assert!(labels >= 6 && labels <= ticks.len(), "{labels} labels of {} ticks", ticks.len());
        assert!(points.len() > 20 * labels, "{} points", points.len());
    }

    #[test]
    fn a_label_that_would_go_beyond_a_corner_is_left_out() {
        let corners = [DVec2::splat(30.0), DVec2::new(400.0, 300.0)];
        let at = |x: f64| label("8°30′E", DVec2::new(x, 30.0), DVec2::Y, corners, &paper(), 1.0).0.len();
        assert!(at(200.0) > 5 && at(395.0) == 0 && at(31.0) == 0);
    }

    #[test]
    fn labels_of_a_typeface_are_where_those_of_strokes_are() {
        let corners = [DVec2::splat(30.0), DVec2::new(400.0, 300.0)];
        for (at, inward) in [
            (DVec2::new(200.0, 30.0), DVec2::Y),
            (DVec2::new(200.0, 300.0), DVec2::NEG_Y),
            (DVec2::new(30.0, 150.0), DVec2::X),
            (DVec2::new(400.0, 150.0), DVec2::NEG_X),
        ] {
            let of = |typeface| label("46°30′N", at, inward, corners, &Paper { typeface, ..paper() }, 1.0);
            let (strokes, none, words) = of(crate::style::Typeface::Strokes);
            let (bare, areas, _) = of(crate::style::Typeface::Serif);
            assert!(none.is_empty() && bare.is_empty() && areas.len() == 7, "{} areas", areas.len());
            let middle = |points: &[DVec2]| {
                let fold = |pick: fn(DVec2, DVec2) -> DVec2| points.iter().copied().reduce(pick).unwrap();
                0.5 * (fold(DVec2::min) + fold(DVec2::max))
            };
            let corners_of = |area: &Area| {
                let around = kurbo::Shape::bounding_box(&area.curves);
                [DVec2::new(around.x0, around.y0), DVec2::new(around.x1, around.y1)]
            };
            let of_areas = middle(&areas.iter().flat_map(corners_of).collect::<Vec<_>>());
            let of_strokes = middle(&strokes.iter().flat_map(|stroke| stroke.points.clone()).collect::<Vec<_>>());
            assert!(of_areas.distance(of_strokes) < 1.5, "{inward}: {of_areas} and {of_strokes}");
            // Planted: the label of another side.
            assert!(of_areas.distance(at + inward * 8.0) > 10.0);
            // The words are where the letters are: their middle is half of the height above that of the baseline.
            let words = words.unwrap();
            let [begin, along] = [words.begin.to_vec2(), words.along].map(|it| DVec2::new(it.x, it.y));
            let middle = begin + 0.5 * along + 0.5 * words.height * DVec2::new(along.y, -along.x).normalize();
            assert!(middle.distance(of_strokes) < 1.5 && words.words == "46°30′N", "{inward}: {middle}");
            // Planted: words that run the other way are on the other side of the baseline.
            let mirrored = begin + 0.5 * along - 0.5 * words.height * DVec2::new(along.y, -along.x).normalize();
            assert!(mirrored.distance(of_strokes) > 4.0);
        }
    }

    #[test]
    fn maps_of_the_world_have_coordinates() {
        // One and a half turns and beyond the poles.
        let coordinates = |px: DVec2| DVec2::new((px.x - 400.0) * 0.5, (250.0 - px.y) * 0.5);
        let world = map_frame([800, 500], &paper(), Coordinates::Degrees, coordinates, 1.0);
        assert!(world.labels >= 12, "{}", world.labels);
        let texts = |values: &[f64], axis| crossings(values, 30.0, Coordinates::Degrees, axis);
        let latitudes: Vec<String> = texts(&[-120.0, 130.0], 1).into_iter().map(|crossing| crossing.label).collect();
        assert_eq!(latitudes, ["90°S", "60°S", "30°S", "0°", "30°N", "60°N", "90°N"]);
    }

    #[test]
    fn a_small_map_has_no_coordinates() {
        let drawn = map_frame([120, 160], &paper(), Coordinates::Lengths, |px| px, 1.0);
        assert_eq!((drawn.strokes.len(), drawn.labels), (1, 0));
    }
}
