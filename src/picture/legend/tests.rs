#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use super::*;
use crate::lines::strokes::polylines::PolylinePoint;
use crate::vector::{GroupKind, InkKind};

fn legend(style: &str) -> Legend {
    Legend::new(&Style::load(style).unwrap().for_map(10.0).unwrap(), 1.0)
}

/// Returns a band of 100 × 100 pixels: ink of layers in the first rows, and heights up to `high_m`.
fn band(legend: &Legend, inked: &[usize], high_m: f32) -> Band {
    let of = |plane: &Plane| match plane.source {
        PlaneSource::Ink(layer) => {
            let is_inked = inked.contains(&layer);
            Samples::F32((0..10_000).map(|i| if is_inked && i < 3000 { 1.0 } else { 0.0 }).collect())
        }
        PlaneSource::WorldPosition(_) => Samples::F32((0..10_000).map(|i| 1.0 + high_m * i as f32 * 1e-4).collect()),
        _ => Samples::U32(vec![1; 10_000]),
    };
    let planes = legend.planes().iter().map(of).collect();
    Band { first_row: 0, rows: 100, picture: vec![[0.0; 4]; 10_000], planes }
}

#[test]
fn entries_are_what_is_drawn() {
    let all = [[0, 100], [0, 100]];
    let layer = |style: &str, is: fn(&Layer) -> bool| Style::load(style).unwrap().layers.iter().position(is).unwrap();
    let [streams, heights, water] = [
        layer("ink", |layer| matches!(layer, Layer::Drainage(lines) if lines.of == DrainageLines::Streams)),
        layer("ink", |layer| matches!(layer, Layer::HeightLines(_))),
        layer("ink", |layer| matches!(layer, Layer::Water(_))),
    ];
    let names = |inked: &[usize], high_m: f32, area: [[usize; 2]; 2]| {
        let mut legend = legend("ink");
        let mut band = band(&legend, inked, high_m);
        band.planes.insert(0, Samples::F32(vec![7.0]));
        legend.look(&mut band, 100, area);
        assert_eq!(band.planes.len(), 1, "the channels that were asked for stay");
        legend.names().into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(names(&[streams], 10.0, all), ["Streams"]);
    assert!(names(&[], 5000.0, all).is_empty(), "planted: nothing is drawn");
    assert_eq!(names(&[water], 10.0, all), ["Water"]);
    let found = names(&[heights], 5000.0, all);
    assert!(matches!(&found[..], [a, b] if a.starts_with("Contour lines every ") && b.starts_with("Index lines ")));
    assert_eq!(names(&[heights], 10.0, all).len(), 1, "land within one interval has no index line");
    // Ink under the margin or the title block is not seen.
    assert!(names(&[streams], 10.0, [[0, 100], [30, 100]]).is_empty());
}

#[test]
fn entries_of_drawings_are_their_groups() {
    let mut legend = legend("ink");
    let group = |id: &str, half_width_px: f32| Group {
        id: id.to_owned(),
        label: String::new(),
        ink: Color::default(),
        kind: GroupKind::Ink(InkKind::Mark),
        lines: vec![Polyline {
            points: vec![PolylinePoint { px: [0.0; 2], half_width_px, ink: 1.0 }],
            ..Polyline::default()
        }],
        fills: Vec::new(),
        texts: Vec::new(),
    };
    legend.look_in(&[group("streams", 1.0), group("hatching", 1.0)]);
    assert_eq!(legend.names(), ["Streams"]);
    legend.look_in(&[group("heights", 0.1)]);
    assert_eq!(legend.names().len(), 1);
    legend.look_in(&[group("heights", 3.0)]);
    assert_eq!(legend.names().len(), 2, "a wide line is an index line");
    legend.look_in(&[]);
    assert!(legend.names().is_empty());
}

#[test]
fn samples_have_the_widths_of_the_style() {
    let mut legend = legend("ink");
    legend.entries.iter_mut().for_each(|entry| entry.is_drawn = true);
    let place = LegendPlace {
        at: DVec2::new(10.0, 20.0),
        room_px: 300.0,
        rows: 9,
        px: 1.0,
        typeface: Typeface::Sans,
        ink: Color::default(),
    };
    let blocks = legend.blocks(&place);
    let style = Style::load("ink").unwrap();
    let lines = style.lowest_height_lines().unwrap();
    let widths: Vec<f64> = blocks
        .iter()
        .filter(|block| block.ink == lines.ink)
        .flat_map(|block| block.strokes.iter().map(|stroke| stroke.width_px))
        .collect();
    assert!([lines.line_px, lines.index_px].iter().all(|px| widths.contains(&f64::from(*px))), "{widths:?}");
    // Everything is within the space.
    let points = blocks.iter().flat_map(|block| &block.strokes).flat_map(|stroke| &stroke.points);
    assert!(points.clone().count() > 100);
    assert!(
        points
            .clone()
            .all(|at| at.x >= 9.0 && at.x <= 310.0 && at.y >= 20.0 - LEGEND_HEIGHT && at.y <= 20.0 + 9.0 * ROW)
    );
    // Planted: narrower than an entry, so that each has a row of its own.
    let entries: Vec<&Entry> = legend.entries.iter().collect();
    assert_eq!(rows(&entries, 10.0, Typeface::Sans).len(), entries.len());
    assert!(most_rows(&style.for_map(1.0).unwrap(), 2000.0) == 1);
}
