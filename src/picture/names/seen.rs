//! Which sites a picture shows, by the distances of its surface.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use super::Site;
use crate::frame::{Renderer, SeenDistances};
use crate::gpu::{Gpu, GpuError};
use crate::picture::PictureRequest;
use crate::scene::stereo::Pair;
use crate::scene::view::{Rig, View};
use crate::tiles::earth_curvature::EarthCurvature;
use crate::world::Surfaces;

/// Longest side of the picture on which the visible places are found. Lengths on larger pictures grow with it.
const SEEN_PX: f64 = 1920.0;
/// Half of the side of the square of pixels in which a place is looked for: the surface is drawn within a pixel.
const LOOK_PX: f64 = 2.0;
/// How far a place may be from the surface that a pixel shows: across the view in pixels, and along it as a share of the
/// distance. The highest sample of a broad summit is often hidden behind the rim of the summit itself.
const OFF_PX: f64 = 4.0;
const BEHIND: f64 = 0.02;
/// Factor on these tolerances for a site whose label is drawn, so that the label of a summit that nearer land touches does
/// not blink.
const HELD: f64 = 1.5;

/// A site on a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Index of the site.
    pub site: usize,
    /// Position on the picture of the first eye, in pixels.
    pub px: DVec2,
    /// How much farther to the right the site is on the picture of the right eye of a stereo pair, in pixels.
    pub apart_px: f64,
    /// How far below the skyline the site is, in pixels: the length of a leader on other land.
    pub below_px: f64,
}

/// What a picture shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Visible {
    pub sites: Vec<Seen>,
    /// Sites that have labels and are no longer visible, with their positions.
    pub hidden: Vec<Seen>,
    /// The upper end of the land, in pixels; the height of the picture if it shows none.
    pub land_top_px: f64,
}

/// Sites that are looked for on a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted<'a> {
    pub sites: &'a [Site],
    /// Indices of the sites whose labels the picture before has.
    pub held: &'a BTreeSet<usize>,
}

/// The surface that the eyes of a picture saw. A stereo pair shows a site if both eyes see it.
pub(crate) struct SeenSurface {
    /// The point that positions are relative to.
    origin_m: DVec3,
    earth: EarthCurvature,
    eyes: Vec<EyeSurface>,
}

struct EyeSurface {
    view: View,
    distances: SeenDistances,
    /// The upper end of the land in each column, in pixels; the height of the picture where there is none.
    skyline_px: Vec<f64>,
}

/// Finds the sites that a picture shows, on a picture of the whole without lines and tones. `renderer` draws it, and is
/// created if there is none.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn visible(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
    wanted: Wanted<'_>,
) -> Result<Visible, GpuError> {
    let longest = f64::from(request.size_px.into_iter().max().unwrap_or(1).max(1));
    let factor = (SEEN_PX / longest).min(1.0);
    let size_px = request.size_px.map(|side| ((f64::from(side) * factor).round() as u32).max(1));
    let style = request.style.of_tones().scaled(factor);
    let rig = |size_px| {
        let view = View { clock: request.clock, ..View::whole(request.pose, request.pose, size_px) };
        pair.map_or_else(|| Rig::mono(view), |pair| pair.rig(&view))
    };
    let drawn = rig(size_px);
    let renderer = Renderer::or_new(renderer, gpu)?;
    renderer.set_only_strokes(true);
    renderer.render_eyes(gpu, world, &drawn, &style, &request.light)?;
    let surface = SeenSurface::read(gpu, renderer, world, &drawn)?;
    Ok(surface.map(|surface| surface.visible(wanted, &rig(request.size_px))).unwrap_or_default())
}

/// Returns where a place is on the picture of the first eye of a rig, and how much farther to the right it is on that of
/// the last one, in pixels; `None` if it is not in front of an eye.
pub(crate) fn placed_on(rig: &Rig, earth: &EarthCurvature, world_m: DVec3) -> Option<(DVec2, f64)> {
    let way = earth.bend(world_m - rig.origin_m);
    let on = |eye: &View| eye.place_px(way - (eye.pose.position_m - rig.origin_m)).filter(|px| px.is_finite());
    let (first, last) = (on(rig.eyes.first()?)?, on(rig.eyes.last()?)?);
    Some((first, last.x - first.x))
}

impl SeenSurface {
    /// Reads what the eyes of the last frame saw. Returns `None` if the renderer has no pictures of these eyes.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub(crate) fn read(gpu: &Gpu, renderer: &Renderer, world: &Surfaces, rig: &Rig) -> Result<Option<Self>, GpuError> {
        let read = |eye| renderer.distances(gpu, eye);
        let distances = (0..rig.eyes.len()).map(read).collect::<Result<Option<Vec<_>>, GpuError>>()?;
        let earth = world.terrain.earth_curvature(rig.origin_m.z);
        Ok(distances.and_then(|distances| Self::new(rig, earth, distances)))
    }

    /// Creates the surface that the eyes of a rig saw; `None` if a picture does not have the size of its eye's view.
    pub(crate) fn new(rig: &Rig, earth: EarthCurvature, distances: Vec<SeenDistances>) -> Option<Self> {
        let eye = |(view, distances): (&View, SeenDistances)| {
            let skyline_px = skyline_px(&distances);
            (distances.size_px == view.picture_px).then_some(EyeSurface { view: *view, distances, skyline_px })
        };
        let eyes: Vec<EyeSurface> = rig.eyes.iter().zip(distances).map(eye).collect::<Option<_>>()?;
        (!eyes.is_empty()).then_some(Self { origin_m: rig.origin_m, earth, eyes })
    }

    /// Finds sites, with their positions on a picture of another size, whose eyes are those of `whole`.
    pub(crate) fn visible(&self, wanted: Wanted<'_>, whole: &Rig) -> Visible {
        let mut found = Visible::default();
        for (site, at) in wanted.sites.iter().enumerate() {
            let is_held = wanted.held.contains(&site);
            let Some((seen, is_visible)) = self.look(at.world_m, if is_held { HELD } else { 1.0 }, whole) else {
                continue;
            };
            let seen = Seen { site, ..seen };
            match (is_visible, is_held) {
                (true, _) => found.sites.push(seen),
                (false, true) => found.hidden.push(seen),
                (false, false) => {}
            }
        }
        let tops = self.eyes.iter().zip(&whole.eyes).map(|(eye, whole)| {
            let top = eye.skyline_px.iter().copied().fold(f64::from(eye.distances.size_px[1]), f64::min);
            top * eye.factor(whole)
        });
        found.land_top_px = tops.fold(f64::INFINITY, f64::min);
        found
    }

    /// Returns where a place is on the picture, and whether all eyes see it; `None` if it is not in front of them.
    fn look(&self, world_m: DVec3, slack: f64, whole: &Rig) -> Option<(Seen, bool)> {
        let way = self.earth.bend(world_m - self.origin_m);
        // The same direction on the picture itself.
        let (px, apart_px) = placed_on(whole, &self.earth, world_m)?;
        let (mut is_visible, mut below_px) = (true, 0.0_f64);
        for (eye, whole) in self.eyes.iter().zip(&whole.eyes) {
            let from_eye = way - (eye.view.pose.position_m - self.origin_m);
            let at = eye.view.place_px(from_eye)?;
            is_visible = is_visible && eye.shows(at, way, from_eye.length(), slack);
            let column = (at.x.max(0.0) as usize).min(eye.skyline_px.len() - 1);
            below_px = below_px.max((at.y - eye.skyline_px[column]).max(0.0) * eye.factor(whole));
        }
        Some((Seen { site: 0, px, apart_px, below_px }, is_visible))
    }
}

impl EyeSurface {
    /// Returns the number of pixels of a picture per pixel of this one.
    fn factor(&self, whole: &View) -> f64 {
        f64::from(whole.picture_px[0]) / f64::from(self.distances.size_px[0])
    }

    /// Returns whether a pixel near `px` shows the surface at `way`, in metres from the origin, which is `away_m` from the
    /// eye.
    fn shows(&self, px: DVec2, way: DVec3, away_m: f64, slack: f64) -> bool {
        let [width, height] = self.distances.size_px.map(|side| side as i32);
        let middle = px.floor();
        if !middle.is_finite() || middle.abs().max_element() > 1e9 {
            return false;
        }
        let [x, y] = [middle.x as i32, middle.y as i32];
        if x < 0 || y < 0 || x >= width || y >= height {
            return false;
        }
        let larger = (f64::from(width.max(height)) / SEEN_PX).max(1.0);
        let look_px = (LOOK_PX * larger).ceil() as i32;
        let across_m = slack * larger * OFF_PX * away_m / self.view.focal_px();
        let along_m = (slack * BEHIND * away_m).max(across_m);
        let toward = way.normalize_or_zero();
        (y - look_px..=y + look_px).filter(|y| (0..height).contains(y)).any(|y| {
            (x - look_px..=x + look_px).filter(|x| (0..width).contains(x)).any(|x| {
                let [east, north, up, depth_m] = self.distances.place([x as u32, y as u32]);
                let off_m = DVec3::new(east.into(), north.into(), up.into()) - way;
                let behind_m = off_m.dot(toward);
                depth_m > 0.0 && behind_m.abs() < along_m && off_m.reject_from_normalized(toward).length() < across_m
            })
        })
    }
}

fn skyline_px(distances: &SeenDistances) -> Vec<f64> {
    let [width, height] = distances.size_px;
    let mut tops = vec![f64::from(height); width as usize];
    let mut open = width;
    for y in 0..height {
        for (x, top) in (0..width).zip(&mut tops) {
            if *top >= f64::from(height) && distances.distance_m([x, y]) > 0.0 {
                *top = f64::from(y);
                open -= 1;
            }
        }
        if open == 0 {
            break;
        }
    }
    tops
}
