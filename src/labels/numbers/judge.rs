//! Compares windows with the page.

use glam::DVec2;
use rustc_hash::FxHashSet;

use super::course::{Course, Estimate, Role, turned};
use super::frame::{Frame, bounds, pass};
use super::grid::Segments;
use super::paths::{Path, Paths};
use super::ranks::Ranks;
use super::stretch::Stretch;
use super::{Contour, Every, Page, Rules, Tops};

/// Distance of the text from the ends of its gap, in letter heights.
const MARGIN: f64 = 1.0 / 3.0;
/// Length of line that remains between the gap and the end of an open line, in letter heights.
const STUB: f64 = 1.0;
/// Distance of numbers from the border of the page, in letter heights.
const BORDER: f64 = 0.3;
/// Distance between a number and other contour lines that costs nothing, in letter heights; index contours must have
/// half of it.
const CLEAR: f64 = 0.2;
/// Part of the height of the digits in which a line is in their middle.
const CORE: f64 = 0.35;
/// Costs of each line in the middle of the digits, and of each line that only touches them.
const CROSSED: f64 = 0.65;
const TOUCHED: f64 = 0.35;
/// Additional cost of numbers on lines that are no index contours, which are then numbered less often.
const MINOR: f64 = 0.8;
/// Free land that a number outside of ladders needs on all sides, in letter heights.
const FREE: f64 = 1.6;
/// A line that deviates this much from the arc on average costs 1, in letter heights; the largest deviation.
const OFF: f64 = 0.09;
const MAX_OFF: f64 = 0.3;
/// Cosine of the largest angle between the tops of the digits and uphill, and that of one that costs nothing.
const MIN_UPHILL: f64 = 0.64;
/// Cost of tops that are [`MIN_UPHILL`] away from uphill.
const ASKEW: f64 = 1.5;
/// Number of positions on a line at which the side of uphill is looked for.
const SIDES: usize = 9;

/// The contour lines, the page and the rules, prepared for finding positions.
pub(super) struct Map<'a> {
    pub contours: &'a [Contour<'a>],
    pub page: &'a Page<'a>,
    pub rules: &'a Rules,
    pub paths: Paths,
    pub segments: Segments,
    pub courses: Vec<Course>,
    /// For each line, its course.
    pub course_of: Vec<Option<usize>>,
    /// Number of different levels.
    pub levels: usize,
}

/// A possible position of a number.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub course: usize,
    pub window: usize,
    pub frame: Frame,
    pub gap_px: [f64; 2],
    pub cost: f64,
}

impl<'a> Map<'a> {
    pub(super) fn new(contours: &'a [Contour<'a>], page: &'a Page<'a>, rules: &'a Rules) -> Self {
        let paths = Paths::new(contours.iter().map(|contour| (contour.points, contour.is_closed)));
        let segments = Segments::new(&paths, page.corners_px, 1.5 * page.letter_px);
        let mut map = Self {
            contours,
            page,
            rules,
            paths,
            segments,
            courses: Vec::new(),
            course_of: vec![None; contours.len()],
            levels: 0,
        };
        let in_ladders = |contour: &Contour<'_>| contour.is_index || rules.every == Every::All;
        let wanted = |line: &usize| rules.every == Every::Auto || in_ladders(&contours[*line]);
        let lines: Vec<usize> = (0..contours.len()).filter(|line| is_level(&contours[*line])).filter(wanted).collect();
        let levels = Ranks::new(lines.iter().map(|line| &contours[*line]));
        let rungs = Ranks::new(lines.iter().map(|line| &contours[*line]).filter(|contour| in_ladders(contour)));
        map.levels = levels.len();
        for line in lines {
            let contour = &contours[line];
            let Some(width_px) = map.width_px(contour.text) else { continue };
            let role = Role {
                line,
                width_px,
                gap_px: width_px + 2.0 * MARGIN * page.letter_px,
                level: levels.of(contour),
                rung: in_ladders(contour).then(|| rungs.of(contour)),
                side: 0.0,
                cost: if contour.is_index { 0.0 } else { MINOR },
            };
            let path = map.paths.path(line);
            if let Some(mut course) = Course::new(role, &path, page.letter_px) {
                course.role.side = map.side(&path);
                map.course_of[line] = Some(map.courses.len());
                map.courses.push(course);
            }
        }
        map
    }

    fn width_px(&self, text: &str) -> Option<f64> {
        let width_px = if text.is_empty() { 0.0 } else { (self.page.width_px)(text) };
        (width_px.is_finite() && width_px > 0.0).then_some(width_px)
    }

    /// Returns the unit direction of uphill.
    pub(super) fn uphill(&self, at: DVec2) -> Option<DVec2> {
        (self.page.uphill)(at).and_then(DVec2::try_normalize)
    }

    /// Returns 1 if uphill is on the right of a line, −1 if it is on its left, 0 if it is unknown.
    fn side(&self, path: &Path<'_>) -> f64 {
        let step_px = path.length_px() / SIDES as f64;
        let vote = |i: usize| {
            let along_px = (i as f64 + 0.5) * step_px;
            let [before, at, after] = [-0.5, 0.0, 0.5].map(|by| path.at(along_px + by * self.page.letter_px));
            self.uphill(at).map_or(0.0, |uphill| (after - before).normalize_or_zero().perp().dot(uphill))
        };
        let sum: f64 = (0..SIDES).map(vote).sum();
        if sum == 0.0 { 0.0 } else { sum.signum() }
    }

    /// Estimates the cost of a window from the line alone.
    pub(super) fn estimate(&self, course: usize, window: usize) -> Option<Estimate> {
        self.courses[course].estimate(window, self.page.letter_px, self.rules.tops)
    }

    /// Returns the position of the number in a window with its full cost, or `None` if it breaks a rule.
    pub(super) fn judge(&self, course: usize, window: usize) -> Option<Candidate> {
        let Estimate { frame, mut cost } = self.estimate(course, window)?;
        let (letter_px, role) = (self.page.letter_px, &self.courses[course].role);
        let path = self.paths.path(role.line);
        let middle_px = self.courses[course].middle_px(window);
        if role.rung.is_none() {
            // Most of these windows have no free land around them, which is found quickly.
            self.crossings(role, &frame, [-0.5, 0.5].map(|part| middle_px + part * role.gap_px))?;
        }
        let stretch = Stretch::new(&path, middle_px, 0.5 * role.gap_px + 1.5 * letter_px, letter_px);
        let (frame, off_px) = stretch.fitted(frame, role.width_px)?;
        if off_px[1] > MAX_OFF * letter_px {
            return None;
        }
        cost += (off_px[0] / (OFF * letter_px)).powi(2);
        let gap_px = stretch.gap(&frame, 0.5 * role.gap_px)?;
        let needed_px = STUB * letter_px;
        if !path.is_closed && (gap_px[0] < needed_px || gap_px[1] > path.length_px() - needed_px) {
            return None;
        }
        if gap_px[1] - gap_px[0] > 1.3 * role.gap_px || stretch.is_sharp(gap_px, letter_px) {
            return None;
        }
        let frame = self.oriented(frame, role.width_px, &mut cost)?;
        let border_px = DVec2::splat(BORDER * letter_px);
        let [low, high] = bounds(&frame.quads(role.width_px, letter_px));
        let [page_low, page_high] = self.page.corners_px;
        if low.cmplt(page_low + border_px).any() || high.cmpgt(page_high - border_px).any() {
            return None;
        }
        cost += self.crossings(role, &frame, gap_px)?;
        Some(Candidate { course, window, frame, gap_px, cost })
    }

    /// Compares the tops of the digits with uphill along the text, and turns the number if that is needed.
    fn oriented(&self, frame: Frame, width_px: f64, cost: &mut f64) -> Option<Frame> {
        if self.rules.tops == Tops::Upright {
            return Some(turned(frame, 0.0, Tops::Upright));
        }
        let agreement = |u: f64| self.uphill(frame.point(u, 0.0)).map(|uphill| -frame.direction(u).perp().dot(uphill));
        let known = [-0.5, -0.25, 0.0, 0.25, 0.5].map(|part| agreement(part * width_px));
        let least = known.into_iter().flatten().fold(f64::INFINITY, f64::min);
        let most = known.into_iter().flatten().fold(f64::NEG_INFINITY, f64::max);
        if least.is_infinite() {
            return Some(frame);
        }
        let (frame, least) = if most < 0.0 { (frame.reversed(), -most) } else { (frame, least) };
        if least < MIN_UPHILL {
            return None;
        }
        *cost += ASKEW * ((1.0 - least) / (1.0 - MIN_UPHILL)).powi(2);
        // Here the number turned out to be the other way up than its line is elsewhere.
        if most < 0.0 && frame.along.x < 0.0 {
            *cost += ASKEW;
        }
        Some(frame)
    }

    /// Returns the cost of the lines under the digits, or `None` if they are index contours.
    fn crossings(&self, role: &Role, frame: &Frame, gap_px: [f64; 2]) -> Option<f64> {
        let letter_px = self.page.letter_px;
        let around_px = if role.rung.is_some() { CLEAR * letter_px } else { FREE * letter_px };
        let half = 0.5 * DVec2::new(role.width_px, letter_px);
        let strict = half + 0.5 * CLEAR * letter_px;
        let reach = half + around_px;
        let far_px = reach.length() + letter_px;
        let quads = frame.quads(2.0 * reach.x, 2.0 * reach.y);
        let [low, high] = bounds(&quads);
        let own = self.paths.path(role.line);
        let gap_middle_px = 0.5 * (gap_px[0] + gap_px[1]);
        // The line itself next to the gap is no other line.
        let own_px = 0.5 * (gap_px[1] - gap_px[0]) + letter_px + around_px;
        let (mut is_free, mut lines) = (true, Lines::default());
        self.segments.visit([low, high], |point, line| {
            let [a, b] = self.paths.segment(point);
            let is_far = a.distance(frame.centre) > far_px + a.distance(b);
            if is_far || a.min(b).cmpgt(high).any() || a.max(b).cmplt(low).any() {
                return true;
            }
            if line == role.line {
                let [from_px, to_px] = [self.paths.along_px(point), self.paths.along_px(point + 1)];
                if own.between_px(from_px, to_px, gap_middle_px) <= own_px {
                    return true;
                }
            }
            let Some(away) = passes(frame, a, b, reach) else { return true };
            let is_strict = self.contours[line].is_index || line == role.line;
            is_free = role.rung.is_some() && !(is_strict && passes(frame, a, b, strict).is_some());
            lines.add(line, away < CORE * letter_px);
            is_free
        });
        is_free.then(|| lines.cost())
    }
}

/// Returns the smallest distance from an arc at which a segment passes through the strip around it.
fn passes(frame: &Frame, a: DVec2, b: DVec2, half: DVec2) -> Option<f64> {
    // In the coordinates of a curved number, only short segments are straight.
    let parts = if frame.bend == 0.0 { 1.0 } else { (a.distance(b) / half.y).ceil().clamp(1.0, 1000.0) };
    let point = |i: usize| frame.local(a.lerp(b, i as f64 / parts));
    let passes = (0..parts as usize).filter_map(|i| pass(point(i), point(i + 1), half));
    passes.reduce(f64::min)
}

/// The different lines under a number.
#[derive(Default)]
struct Lines {
    crossed: FxHashSet<usize>,
    touched: FxHashSet<usize>,
}

impl Lines {
    fn add(&mut self, line: usize, is_core: bool) {
        if is_core {
            self.crossed.insert(line);
        }
        self.touched.insert(line);
    }

    fn cost(&self) -> f64 {
        CROSSED * self.crossed.len() as f64 + TOUCHED * (self.touched.len() - self.crossed.len()) as f64
    }
}

/// Returns whether a line can have a number at all.
fn is_level(contour: &Contour<'_>) -> bool {
    contour.level_m.is_finite() && !contour.text.is_empty()
}
