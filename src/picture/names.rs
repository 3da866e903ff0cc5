//! Names and heights of summits and places on a picture. In a view they are in rows above the land, with leaders down to
//! their summits; on a map they are next to their symbols.
//!
//! Only what the picture shows has a name: the surface that is drawn decides what is visible. Where labels are is
//! decided by [`crate::labels::placement`].

use glam::{DVec2, DVec3};

use super::PictureRequest;
use super::title::{MAX_PEN, MIN_PEN, PEN};
use crate::frame::Renderer;
use crate::gpu::{Gpu, GpuError};
use crate::labels::placement::Rect;
use crate::labels::placement::panorama::{Label, Rows, panorama};
use crate::labels::placement::points::{Page, Point, points};
use crate::lettering::Line;
use crate::lettering::area::Area;
use crate::lettering::ink::PenStroke;
use crate::scene::view::{Rig, View};
use crate::style::Paper;
use crate::world::Surfaces;

/// Longest side of the picture on which the visible places are found.
const SEEN_PX: f64 = 1920.0;
/// Half of the side of the square of pixels in which a place is looked for: the surface is drawn within a pixel.
const LOOK_PX: i32 = 2;
/// How far a place may be from the surface that a pixel shows: across the view in pixels, and along it as a share of the
/// distance. The highest sample of a broad summit is often hidden behind the rim of the summit itself.
const OFF_PX: f64 = 4.0;
const BEHIND: f64 = 0.02;

// Lengths are in pixels of the style.

/// Height of capitals on views and on maps.
const LETTERS: [f64; 2] = [8.0, 7.0];
/// Height of a row, distance of the lowest row from the land below it, and the width of leaders.
const ROW: f64 = 17.0;
const ABOVE_LAND: f64 = 14.0;
const LEADER: f64 = 0.7;
/// Distance of a leader from its summit and from its name.
const LEADER_GAPS: [f64; 2] = [3.0, 3.0];
/// Distance of names in a row, from leaders, and from the border.
const GAP: f64 = 9.0;
const LEADER_GAP: f64 = 4.0;
const MARGIN: f64 = 10.0;
/// Length of a leader on other land at which a label counts half as much.
const ON_LAND: f64 = 20.0;
/// Longest leader on other land of a summit without a name.
pub(crate) const MAX_ON_LAND: f64 = 45.0;
/// Largest number of rows.
const MAX_ROWS: usize = 6;
/// Half of the height of a summit's triangle and of a place's ring on a map, and the distance of the name.
const SYMBOL: f64 = 3.2;
const SYMBOL_GAP: f64 = 2.0;
/// Width of the halo around letters on a map.
pub(super) const HALO: f64 = 2.2;

/// A place that may have a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Site {
    /// Position in the world, as the land is drawn.
    pub world_m: DVec3,
    /// The name, the height, or both.
    pub text: String,
    /// Importance, more than 0; the prominence of a summit.
    pub weight: f64,
    /// Whether it is a summit, which has a triangle on maps.
    pub is_summit: bool,
}

/// A site that the picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Index of the site.
    pub site: usize,
    /// Position on the picture, in pixels.
    pub px: DVec2,
    /// How far below the skyline it is, in pixels: the length of a leader on other land.
    pub below_px: f64,
}

/// What a picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Visible {
    pub sites: Vec<Seen>,
    /// The upper end of the land, in pixels; the height of the picture if it shows none.
    pub land_top_px: f64,
}

/// The part of a picture that may have labels, and their inks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    /// Upper left and lower right corner, without margin, border and foot, in pixels.
    pub area_px: [DVec2; 2],
    pub paper: &'a Paper,
    /// Number of pixels per pixel of the style.
    pub px: f64,
}

/// Labels, ready to be drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Labels {
    /// Strokes and letters, in pixels of the picture.
    pub strokes: Vec<PenStroke>,
    pub areas: Vec<Area>,
    /// What is drawn under the letters in the colour of the paper; empty in views.
    pub halo: Vec<PenStroke>,
    /// Characters that neither the lettering nor a font of the machine has.
    pub replaced: Vec<char>,
    /// Indices of the sites with labels.
    pub labelled: Vec<usize>,
}

/// Finds the sites that a picture shows, on a picture of the whole without lines and marks.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn visible(
    gpu: &Gpu,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    sites: &[Site],
) -> Result<Visible, GpuError> {
    let longest = f64::from(request.size_px.into_iter().max().unwrap_or(1).max(1));
    let factor = (SEEN_PX / longest).min(1.0);
    let size_px = request.size_px.map(|side| ((f64::from(side) * factor).round() as u32).max(1));
    let style = request.style.of_tones().scaled(factor);
    let view = View { clock: request.clock, ..View::whole(request.pose, request.pose, size_px) };
    let mut renderer = Renderer::new(gpu)?;
    renderer.render_eyes(gpu, world, &Rig::mono(view), &style, &request.light)?;
    let Some(places) = renderer.places(gpu, 0, [0, 0], size_px)? else { return Ok(Visible::default()) };
    let whole = View::whole(request.pose, request.pose, request.size_px);
    let skyline = skyline_px(&places, size_px);
    let earth = world.terrain.earth_curvature(request.pose.position_m.z);
    let look = |(site, at): (usize, &Site)| {
        let way = earth.bend(at.world_m - request.pose.position_m);
        let seen = view.place_px(way).filter(|px| shows(&places, size_px, *px, way, view.focal_px()))?;
        // The same direction on the picture itself.
        let px = whole.place_px(way)?;
        let top = skyline[(seen.x as usize).min(skyline.len() - 1)];
        let below_px = (seen.y - top).max(0.0) / factor;
        seen.is_finite().then_some(Seen { site, px, below_px })
    };
    let land_top_px = skyline.iter().copied().fold(f64::from(size_px[1]), f64::min) / factor;
    Ok(Visible { sites: sites.iter().enumerate().filter_map(look).collect(), land_top_px })
}

/// Returns the upper end of the land in each column, in pixels; the height of the picture where there is none.
fn skyline_px(places: &[[f32; 4]], [width, height]: [u32; 2]) -> Vec<f64> {
    let is_land = |x: u32, y: u32| places[(y * width + x) as usize][3] > 0.0;
    (0..width).map(|x| f64::from((0..height).find(|y| is_land(x, *y)).unwrap_or(height))).collect()
}

/// Returns whether a pixel near `px` shows the surface at `way`, in metres from the eye.
fn shows(places: &[[f32; 4]], size_px: [u32; 2], px: DVec2, way: DVec3, focal_px: f64) -> bool {
    let [width, height] = size_px.map(|side| side as i32);
    let middle = px.floor();
    if !middle.is_finite() || middle.abs().max_element() > 1e9 {
        return false;
    }
    let [x, y] = [middle.x as i32, middle.y as i32];
    if x < 0 || y < 0 || x >= width || y >= height {
        return false;
    }
    let away_m = way.length();
    let (across_m, along_m) = (OFF_PX * away_m / focal_px, (BEHIND * away_m).max(OFF_PX * away_m / focal_px));
    let toward = way / away_m.max(1e-6);
    (y - LOOK_PX..=y + LOOK_PX).filter(|y| (0..height).contains(y)).any(|y| {
        (x - LOOK_PX..=x + LOOK_PX).filter(|x| (0..width).contains(x)).any(|x| {
            let [east, north, up, depth_m] = places[(y * width + x) as usize];
            let off_m = DVec3::new(east.into(), north.into(), up.into()) - way;
            let behind_m = off_m.dot(toward);
            depth_m > 0.0 && behind_m.abs() < along_m && off_m.reject_from_normalized(toward).length() < across_m
        })
    })
}

/// Lays out names in rows above the land, and draws them.
/// `land_top_px` is the upper end of all land.
pub(crate) fn above_land(sites: &[Site], seen: &[Seen], land_top_px: f64, ground: &Ground<'_>) -> Labels {
    let px = ground.px;
    let [low, high] = ground.area_px;
    let height_px = LETTERS[0] * px;
    let lines: Vec<Line> = seen.iter().map(|at| Line::small(&sites[at.site].text, ground.paper.typeface)).collect();
    let labels: Vec<Label> = seen
        .iter()
        .zip(&lines)
        .map(|(at, line)| Label {
            x_px: [at.px.x - low.x; 2],
            y_px: at.px.y,
            width_px: line.width() * height_px,
            height_px,
            weight: sites[at.site].weight / (1.0 + at.below_px / (ON_LAND * px)),
        })
        .collect();
    let rows = Rows {
        tops_px: tops_px(land_top_px, ground),
        width_px: high.x - low.x,
        margin_px: MARGIN * px,
        gap_px: GAP * px,
        leader_gap_px: LEADER_GAP * px,
        align: 0.5,
    };
    let mut drawn = Labels::default();
    for ((place, at), line) in panorama(&labels, &rows, &[]).iter().zip(seen).zip(&lines) {
        let Some(place) = place else { continue };
        let bottom = rows.tops_px[place.row] + height_px;
        drawn.write(line, DVec2::new(at.px.x + place.offset_px, bottom), height_px, px);
        let ends = [bottom + LEADER_GAPS[0] * px, at.px.y - LEADER_GAPS[1] * px];
        if ends[1] > ends[0] {
            let [from, to] = ends.map(|y| DVec2::new(at.px.x, y));
            drawn.strokes.push(PenStroke::line(from, to, LEADER * px));
        }
        drawn.labelled.push(at.site);
    }
    // Where there is no room in the sky, names are on land.
    if rows.tops_px.iter().any(|top| top + height_px > land_top_px) {
        drawn.add_halo(HALO * px);
    }
    drawn
}

/// Returns the upper sides of rows, from the top: as many as there is room for between the border and the land, and one
/// at the border if there is none.
fn tops_px(land_top_px: f64, ground: &Ground<'_>) -> Vec<f64> {
    let px = ground.px;
    let [low, high] = ground.area_px;
    let (top, row_px) = (low.y + MARGIN * px, ROW * px);
    let lowest = land_top_px.min(high.y) - ABOVE_LAND * px;
    let rows = ((lowest - top) / row_px).floor().clamp(1.0, MAX_ROWS as f64);
    let first = (lowest - rows * row_px).max(top);
    let tops = (0..rows as usize).map(|row| first + row as f64 * row_px);
    tops.filter(|top| top + LETTERS[0] * px <= high.y).collect()
}

/// Lays out names next to their symbols on a map, and draws them.
pub(crate) fn on_map(sites: &[Site], seen: &[Seen], ground: &Ground<'_>) -> Labels {
    let px = ground.px;
    let height_px = LETTERS[1] * px;
    let lines: Vec<Line> = seen.iter().map(|at| Line::small(&sites[at.site].text, ground.paper.typeface)).collect();
    let named: Vec<Point> = seen
        .iter()
        .zip(&lines)
        .map(|(at, line)| Point {
            at_px: at.px.to_array(),
            radius_px: SYMBOL * px,
            size_px: [line.width() * height_px, height_px],
            weight: sites[at.site].weight,
        })
        .collect();
    let inset = DVec2::splat(0.5 * MARGIN * px);
    let [low, high] = [ground.area_px[0] + inset, ground.area_px[1] - inset];
    let area = Rect { from_px: low.to_array(), to_px: high.max(low).to_array() };
    let page = Page { area, gap_px: 2.0 * px, symbol_gap_px: SYMBOL_GAP * px };
    let mut drawn = Labels::default();
    for (((side, at), line), point) in points(&named, &page, &[], &[]).iter().zip(seen).zip(&lines).zip(&named) {
        let Some(side) = side else { continue };
        let Rect { from_px: [left, _], to_px: [_, bottom] } = point.name_box(*side, &page);
        drawn.symbol(at.px, sites[at.site].is_summit, px);
        drawn.write(line, DVec2::new(left, bottom), height_px, px);
        drawn.labelled.push(at.site);
    }
    drawn.add_halo(HALO * px);
    drawn
}

impl Labels {
    fn write(&mut self, line: &Line, at: DVec2, height_px: f64, px: f64) {
        self.replaced.extend(&line.replaced);
        let width_px = (PEN * height_px).max((MIN_PEN * px).min(MAX_PEN * height_px));
        self.strokes.extend(line.strokes(at, height_px).into_iter().map(|points| PenStroke { points, width_px }));
        self.areas.extend(line.areas(at, height_px));
    }

    /// Draws a triangle or a ring.
    fn symbol(&mut self, at: DVec2, is_summit: bool, px: f64) {
        let corners = if is_summit { 3 } else { 12 };
        let around = |i: usize| {
            let turn = std::f64::consts::TAU * i as f64 / corners as f64;
            at + SYMBOL * px * DVec2::new(turn.sin(), -turn.cos())
        };
        self.strokes.push(PenStroke { points: (0..=corners).map(around).collect(), width_px: 1.1 * px });
    }

    /// Adds a halo around everything that is drawn.
    fn add_halo(&mut self, width_px: f64) {
        self.halo = halo(&self.strokes, &self.areas, width_px);
    }
}

/// Returns strokes that cover the given strokes and areas, and `width_px` around them.
pub(super) fn halo(strokes: &[PenStroke], areas: &[Area], width_px: f64) -> Vec<PenStroke> {
    let wider = |stroke: &PenStroke| PenStroke { width_px: stroke.width_px + 2.0 * width_px, ..stroke.clone() };
    let outlines = areas.iter().flat_map(Area::outlines);
    let around = outlines.map(|points| PenStroke { points, width_px: 2.0 * width_px });
    strokes.iter().map(wider).chain(around).collect()
}

/// Returns the text of a label: the name, and the height in whole metres.
pub(crate) fn label(name: Option<&str>, height_m: Option<f64>) -> String {
    let height = height_m.map(|height_m| super::title::grouped(height_m.round()));
    match (name, height) {
        (Some(name), Some(height)) => format!("{name} {height}"),
        (Some(name), None) => name.to_owned(),
        (None, height) => height.unwrap_or_default(),
    }
}
