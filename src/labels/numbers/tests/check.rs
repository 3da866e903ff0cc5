//! Checks of placed numbers that share no code with the placement.

use glam::DVec2;

use crate::labels::numbers::{Contour, Number, Page, Rules, Tops};

/// Rules that a number may break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The text is not that of the nearest line.
    Level,
    /// The text is not on its line, or not along it.
    OffLine,
    /// The line bends by more than 45° on the height of a letter.
    Bend,
    /// The gap does not fit the text.
    Gap,
    /// The tops of the digits do not point uphill, or the number is upside down.
    Tops,
    /// Numbers of the same level are too close to each other.
    Spacing,
    Page,
    Obstacle,
    Overlap,
    /// Another index contour passes under the digits.
    Crossing,
}

/// Returns the faults of numbers, with the index of the number.
pub(super) fn faults(
    contours: &[Contour<'_>],
    page: &Page<'_>,
    rules: &Rules,
    numbers: &[Number],
) -> Vec<(usize, Fault)> {
    let mut faults = Vec::new();
    for (i, number) in numbers.iter().enumerate() {
        let boxes = boxes(number);
        let line = line(&contours[number.line]);
        let is_broken = [
            (Fault::Level, nearest(contours, number).text != number.text),
            (Fault::OffLine, is_off(number, &line)),
            (Fault::Bend, largest_bend(number, &line) > 45.0),
            (Fault::Gap, !fits(number, &line)),
            (Fault::Tops, is_askew(number, page, rules)),
            (Fault::Page, boxes.iter().any(|own| own.points().any(|at| !is_inside(at, page.corners_px)))),
            (
                Fault::Obstacle,
                boxes.iter().any(|own| own.points().any(|at| page.obstacles_px.iter().any(|it| is_inside(at, *it)))),
            ),
            (Fault::Crossing, is_crossed(contours, number, &boxes)),
        ];
        faults.extend(is_broken.into_iter().filter(|(_, is_broken)| *is_broken).map(|(fault, _)| (i, fault)));
        for (other, own) in numbers.iter().enumerate().take(i) {
            let away_px = own.centre_px.distance(number.centre_px);
            let [a, b] = [own, number].map(|number| &contours[number.line]);
            let needed_px = if own.line == number.line { rules.spacing_px } else { 0.5 * rules.spacing_px };
            if a.level_m == b.level_m && a.is_depth == b.is_depth && away_px < needed_px - 1e-6 {
                faults.push((i, Fault::Spacing));
            }
            if away_px < own.size_px.x + number.size_px.x && boxes_overlap(&boxes, &self::boxes(&numbers[other])) {
                faults.push((i, Fault::Overlap));
            }
        }
    }
    faults
}

/// The rectangle of a letter.
struct LetterBox {
    left: DVec2,
    along: DVec2,
    size: DVec2,
}

impl LetterBox {
    fn point(&self, x: f64, y: f64) -> DVec2 {
        self.left + x * self.size.x * self.along - y * self.size.y * self.along.perp()
    }

    fn points(&self) -> impl Iterator<Item = DVec2> {
        (0..=6).flat_map(move |x| (0..=6).map(move |y| self.point(f64::from(x) / 6.0, f64::from(y) / 6.0)))
    }

    fn contains(&self, at: DVec2) -> bool {
        let (x, y) = ((at - self.left).dot(self.along), -(at - self.left).dot(self.along.perp()));
        (0.0..=self.size.x).contains(&x) && (0.0..=self.size.y).contains(&y)
    }

    fn middle(&self) -> DVec2 {
        self.point(0.5, 0.5)
    }
}

fn boxes(number: &Number) -> Vec<LetterBox> {
    let count = number.text.chars().count();
    let advance_px = number.size_px.x / count as f64;
    let letter = |i: usize| {
        let letter = number.letter(i as f64 * advance_px, advance_px);
        let size = DVec2::new(advance_px, number.size_px.y);
        LetterBox { left: letter.left_px, along: DVec2::new(letter.angle.cos(), letter.angle.sin()), size }
    };
    (0..count).map(letter).collect()
}

fn boxes_overlap(a: &[LetterBox], b: &[LetterBox]) -> bool {
    let meets = |a: &[LetterBox], b: &[LetterBox]| {
        a.iter().any(|own| own.points().any(|at| b.iter().any(|other| other.contains(at))))
    };
    meets(a, b) || meets(b, a)
}

fn is_inside(at: DVec2, [low, high]: [DVec2; 2]) -> bool {
    at.x >= low.x && at.y >= low.y && at.x <= high.x && at.y <= high.y
}

/// Returns the valid points of a line; those of a closed line two times, for gaps over its first point.
fn line(contour: &Contour<'_>) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = contour.points.iter().copied().filter(|point| point.is_finite()).collect();
    points.dedup();
    if contour.is_closed {
        if points.first() != points.last() {
            points.push(points[0]);
        }
        let again: Vec<DVec2> = points.iter().skip(1).copied().collect();
        points.extend(again);
    }
    points
}

/// Returns the point at an arc length, step by step from the beginning.
fn at(line: &[DVec2], along_px: f64) -> DVec2 {
    let mut left_px = along_px;
    for pair in line.windows(2) {
        let step_px = pair[0].distance(pair[1]);
        if left_px <= step_px {
            return pair[0] + (pair[1] - pair[0]) * (left_px / step_px);
        }
        left_px -= step_px;
    }
    line[line.len() - 1]
}

/// Returns the part of a line from one arc length to another, in small steps.
fn part(line: &[DVec2], [from_px, to_px]: [f64; 2]) -> Vec<DVec2> {
    let count = 80;
    (0..=count).map(|i| at(line, from_px + (to_px - from_px) * f64::from(i) / f64::from(count))).collect()
}

fn nearest<'a>(contours: &'a [Contour<'a>], number: &Number) -> &'a Contour<'a> {
    let middle = number.letter(0.0, number.size_px.x);
    let along = DVec2::new(middle.angle.cos(), middle.angle.sin());
    let center = middle.left_px + 0.5 * number.size_px.x * along - 0.5 * number.size_px.y * along.perp();
    let away = |contour: &Contour<'_>| {
        contour.points.windows(2).map(|pair| to_segment(center, pair[0], pair[1])).fold(f64::INFINITY, f64::min)
    };
    contours.iter().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap()
}

fn to_segment(at: DVec2, a: DVec2, b: DVec2) -> f64 {
    let part = (at - a).dot(b - a) / (b - a).length_squared();
    at.distance(a + (b - a) * if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 })
}

fn is_off(number: &Number, line: &[DVec2]) -> bool {
    let part = part(line, number.gap_px);
    let mut sum = 0.0;
    let boxes = boxes(number);
    for own in &boxes {
        let segments = part.windows(2);
        let nearest = segments
            .min_by(|a, b| {
                let [a, b] = [a, b].map(|pair| to_segment(own.middle(), pair[0], pair[1]));
                a.total_cmp(&b)
            })
            .unwrap();
        let away = to_segment(own.middle(), nearest[0], nearest[1]);
        let side = (own.middle() - nearest[0]).dot(own.along.perp()).signum();
        sum += side * away;
        if away > 0.35 * number.size_px.y {
            return true;
        }
    }
    let [along, way] = [boxes[0].along + boxes[boxes.len() - 1].along, part[part.len() - 1] - part[0]];
    let is_aslant = along.normalize().dot(way.normalize()).abs() < 25.0_f64.to_radians().cos();
    sum.abs() / boxes.len() as f64 > 0.12 * number.size_px.y || is_aslant
}

/// Returns the largest bend from one letter height to the next under a number, in degrees.
fn largest_bend(number: &Number, line: &[DVec2]) -> f64 {
    let letter_px = number.size_px.y;
    let [from_px, to_px] = number.gap_px;
    let bend = |i: u32| {
        let along_px = from_px + (to_px - from_px) * f64::from(i) / 60.0;
        let [a, b, c] = [-1.0, 0.0, 1.0].map(|by| at(line, along_px + by * letter_px));
        let (before, after) = (b - a, c - b);
        if along_px < letter_px { 0.0 } else { (before.perp_dot(after)).atan2(before.dot(after)).abs().to_degrees() }
    };
    (0..=60).map(bend).fold(0.0, f64::max)
}

fn fits(number: &Number, line: &[DVec2]) -> bool {
    let boxes = boxes(number);
    let [first, last] = [&boxes[0], &boxes[boxes.len() - 1]];
    let [left, right] = [first.point(0.0, 0.5), last.point(1.0, 0.5)];
    let [begin, end] = number.gap_px.map(|along_px| at(line, along_px));
    let margins = if begin.distance(left) < begin.distance(right) {
        [begin.distance(left), end.distance(right)]
    } else {
        [begin.distance(right), end.distance(left)]
    };
    margins.iter().all(|margin| (0.2..0.7).contains(&(margin / number.size_px.y)))
}

fn is_askew(number: &Number, page: &Page<'_>, rules: &Rules) -> bool {
    boxes(number).iter().any(|own| {
        let top = -own.along.perp();
        match rules.tops {
            Tops::Upright => top.y > 0.35,
            Tops::Uphill => (page.uphill)(own.middle()).is_some_and(|uphill| top.dot(uphill.normalize()) < 0.5),
        }
    })
}

fn is_crossed(contours: &[Contour<'_>], number: &Number, boxes: &[LetterBox]) -> bool {
    contours.iter().enumerate().any(|(i, contour)| {
        let is_other = contour.is_index && i != number.line;
        is_other
            && contour.points.windows(2).any(|pair| {
                let is_near = to_segment(number.centre_px, pair[0], pair[1]) < number.size_px.length();
                let steps = (2.0 * pair[0].distance(pair[1])).ceil() as usize + 1;
                let mut points = (0..=steps).map(|step| pair[0].lerp(pair[1], step as f64 / steps as f64));
                is_near && points.any(|at| boxes.iter().any(|own| own.contains(at)))
            })
    })
}
