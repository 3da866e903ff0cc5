//! The border of a vector drawing: all lines are clipped at it, and it is a line itself. For raster pictures
//! `shaders/shared/paper.wgsl` draws it.

use super::{Group, GroupKind, InkKind};
use crate::lines::strokes::polylines::{Polyline, PolylinePoint};
use crate::style::Paper;

/// Clips all lines to the area inside the paper's margin, and adds the border line, if the paper has one.
pub(crate) fn bordered(groups: &mut Vec<Group>, paper: &Paper, size_px: [u32; 2]) {
    if !paper.is_bordered() {
        return;
    }
    // Lines end under the centre line of the border.
    let middle_px = paper.margin_px + 0.5 * paper.border_px;
    let [right_px, bottom_px] = size_px.map(|side| side as f32 - middle_px);
    let high_px = [right_px, bottom_px - paper.foot_px].map(|side| side.max(middle_px));
    for group in groups.iter_mut() {
        let lines = std::mem::take(&mut group.lines);
        group.lines = lines.into_iter().flat_map(|line| inside(line, [middle_px; 2], high_px)).collect();
    }
    groups.retain(|group| !group.lines.is_empty());
    if paper.border_px > 0.0 {
        let [right, bottom] = high_px;
        let corners = [[middle_px; 2], [right, middle_px], [right, bottom], [middle_px, bottom]];
        let points = corners.map(|px| PolylinePoint { px, half_width_px: 0.5 * paper.border_px, ink: 1.0 }).to_vec();
        let line = Polyline { points, is_closed: true, ..Polyline::default() };
        let label = "Border of the picture".to_owned();
        let kind = GroupKind::Ink(InkKind::Mark);
        groups.push(Group {
            id: "border".to_owned(),
            label,
            ink: paper.border,
            kind,
            lines: vec![line],
            fills: Vec::new(),
            texts: Vec::new(),
        });
    }
}

/// Returns the runs of a line within a rectangle.
fn inside(line: Polyline, low: [f32; 2], high: [f32; 2]) -> Vec<Polyline> {
    let is_in = |at: &PolylinePoint| (0..2).all(|i| at.px[i] >= low[i] && at.px[i] <= high[i]);
    if line.points.iter().all(is_in) {
        return vec![line];
    }
    let mut points = line.points.clone();
    if line.is_closed {
        points.extend(line.points.first().copied());
    }
    let mut runs: Vec<Vec<PolylinePoint>> = Vec::new();
    for pair in points.windows(2) {
        let Some([begin, end]) = part_inside(pair[0], pair[1], low, high) else { continue };
        match runs.last_mut().filter(|run| run.last().is_some_and(|last| last.px == begin.px)) {
            Some(run) => run.push(end),
            None => runs.push(vec![begin, end]),
        }
    }
    runs.into_iter().map(|points| Polyline { points, is_closed: false, ..line.clone() }).collect()
}

/// Returns the part of a segment within a rectangle (Liang and Barsky 1984).
fn part_inside(a: PolylinePoint, b: PolylinePoint, low: [f32; 2], high: [f32; 2]) -> Option<[PolylinePoint; 2]> {
    let (mut begin, mut end) = (0.0_f32, 1.0_f32);
    for i in 0..2 {
        let along = b.px[i] - a.px[i];
        for (way, room) in [(-along, a.px[i] - low[i]), (along, high[i] - a.px[i])] {
            if way == 0.0 && room < 0.0 {
                return None;
            } else if way < 0.0 {
                begin = begin.max(room / way);
            } else if way > 0.0 {
                end = end.min(room / way);
            }
        }
    }
    let at = |t: f32| match t {
        0.0 => a,
        1.0 => b,
        t => {
            let mix = |a: f32, b: f32| a + (b - a) * t;
            PolylinePoint {
                px: [mix(a.px[0], b.px[0]), mix(a.px[1], b.px[1])],
                half_width_px: mix(a.half_width_px, b.half_width_px),
                ink: mix(a.ink, b.ink),
            }
        }
    };
    (begin < end).then(|| [at(begin), at(end)])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    fn line(places: &[[f32; 2]]) -> Polyline {
        let points = places.iter().map(|px| PolylinePoint { px: *px, half_width_px: 1.0, ink: 1.0 }).collect();
        Polyline { points, ..Polyline::default() }
    }

    fn plain() -> Paper {
        crate::style::Style::load("plain").unwrap().paper
    }

    fn places(lines: &[Polyline]) -> Vec<Vec<[f32; 2]>> {
        lines.iter().map(|line| line.points.iter().map(|at| at.px).collect()).collect()
    }

    #[test]
    fn lines_end_at_the_border() {
        let cut = |places: &[[f32; 2]]| inside(line(places), [10.0; 2], [90.0, 50.0]);
        let within = [[20.0, 20.0], [30.0, 40.0]];
        assert_eq!(places(&cut(&within)), [within.to_vec()]);
        // A line that leaves the rectangle and returns.
        let crossing = cut(&[[0.0, 30.0], [50.0, 30.0], [50.0, 70.0], [60.0, 70.0], [60.0, 30.0]]);
        let expected = [vec![[10.0, 30.0], [50.0, 30.0], [50.0, 50.0]], vec![[60.0, 50.0], [60.0, 30.0]]];
        assert_eq!(places(&crossing), expected);
        // Lines across the rectangle, along its outside, and past a corner.
        assert_eq!(places(&cut(&[[0.0, 0.0], [100.0, 60.0]])).len(), 1);
        assert!(cut(&[[0.0, 0.0], [100.0, 0.0]]).is_empty() && cut(&[[5.0, 0.0], [0.0, 9.0]]).is_empty());
    }

    #[test]
    fn a_border_is_a_line_of_its_own() {
        let marks = |lines: Vec<Polyline>| Group {
            id: "marks".into(),
            label: String::new(),
            ink: crate::style::Color::default(),
            kind: GroupKind::Ink(InkKind::Mark),
            lines,
            fills: Vec::new(),
            texts: Vec::new(),
        };
        let paper = Paper { margin_px: 8.0, border_px: 4.0, ..plain() };
        let mut groups =
            vec![marks(vec![line(&[[0.0, 30.0], [50.0, 30.0]])]), marks(vec![line(&[[0.0, 0.0], [1.0, 1.0]])])];
        bordered(&mut groups, &paper, [100, 60]);
        assert_eq!(groups.len(), 2, "marks and the border; the group outside is removed");
        assert_eq!(places(&groups[0].lines), [[[10.0, 30.0], [50.0, 30.0]]]);
        assert!(groups[1].lines[0].is_closed);
        assert_eq!(places(&groups[1].lines), [[[10.0, 10.0], [90.0, 10.0], [90.0, 50.0], [10.0, 50.0]]]);
        // A paper without a border changes nothing.
        let mut bare = vec![marks(vec![line(&[[0.0, 30.0], [50.0, 30.0]])])];
        bordered(&mut bare, &plain(), [100, 60]);
        assert_eq!(places(&bare[0].lines), [[[0.0, 30.0], [50.0, 30.0]]]);
    }
}
