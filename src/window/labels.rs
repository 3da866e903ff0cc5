//! Labels of summits and places over the picture of a window.
//!
//! Nothing here waits. Summits are found on a thread of their own. Which of them the picture shows is decided by the
//! distances of its surface, which are read back asynchronously up to ten times a second and looked at on another thread.
//! In each frame the labels follow the summits by the camera alone.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use egui::{Color32, ColorImage, Shape, TextureHandle, TextureOptions, pos2, vec2};
use glam::DVec2;

use super::background::{Background, NoResult};
use crate::frame::{Renderer, SeenDistances};
use crate::gpu::Gpu;
use crate::gpu::async_readback::{AsyncReadback, ROW_BYTES};
use crate::picture::names::moving::MovingNames;
use crate::picture::names::sites::{Land, Sites};
use crate::picture::names::{
    Ground, LETTER_GAP, LetterMask, Placed, Seen, SeenSurface, Site, Visible, Wanted, leader_px, letter_mask, placed_on,
};
use crate::pyramid::TileStore;
use crate::scene::view::{Rig, ViewUniform};
use crate::source::Silent;
use crate::style::color::srgb_from_linear;
use crate::style::{Color, Typeface};
use crate::surface::DISTANCE;
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::terrain::Terrain;
use crate::world::named_places::NamedPlace;

/// Shortest time from one look at the surface to the next.
const LOOK: Duration = Duration::from_millis(100);
/// Interval at which the program checks for an answer of the GPU while nothing else happens.
const ANSWER_CHECK: Duration = Duration::from_millis(4);
/// Time after the last picture or look in which labels may still fade or move.
const SETTLE: Duration = Duration::from_millis(1600);
/// Number of summits that are labelled if none was given.
pub(super) const PEAKS: usize = 20;

/// Labels that a flight begins with.
#[derive(Clone, Debug, Default)]
pub(crate) struct LabelOptions {
    /// Largest number of summits without names that have labels.
    pub peaks: Option<usize>,
    /// Places with names in the world of the start.
    pub places: Vec<NamedPlace>,
}

/// The labels of a flight.
pub(super) struct Labels {
    is_on: bool,
    options: LabelOptions,
    /// The world of the places.
    world: Option<String>,
    /// The land whose summits are found, or are being found.
    land: Option<Weak<dyn TileStore>>,
    reading: Option<Background<Result<Sites, String>>>,
    sites: Option<Arc<Sites>>,
    readback: Readback,
    asked: Option<Asked>,
    looking: Option<Background<Option<Visible>>>,
    /// What the last picture that was looked at shows, in pixels of the window.
    look: Option<Visible>,
    /// Number of the picture that was looked at last.
    looked: u64,
    next_look: Instant,
    next_check: Instant,
    names: MovingNames,
    /// Typeface, pixels per pixel of the style, and whether the ink is dark.
    drawn_with: Option<(Typeface, f64, bool)>,
    /// The labels of the last frame: site, opacity, and position from the summit.
    last: Vec<(usize, [f64; 3])>,
    /// Whether a label fades or moves.
    moves: bool,
    letters: BTreeMap<usize, Letters>,
    settles_until: Instant,
}

/// A queue for pictures of distances, and how many bytes its answers may have.
struct Readback {
    queue: AsyncReadback,
    bytes: u64,
}

/// A look at the surface whose distances have not arrived yet.
struct Asked {
    eyes: Vec<AskedEye>,
    answers: Vec<Vec<u8>>,
    /// The eyes in the picture, and in the window.
    rig: Rig,
    whole: Rig,
    earth: EarthCurvature,
}

#[derive(Clone, Copy)]
struct AskedEye {
    view: ViewUniform,
    size_px: [u32; 2],
    /// Bytes of a row of the texture.
    row_bytes: usize,
}

/// The letters of a label and their halo, as textures.
struct Letters {
    ink: TextureHandle,
    halo: TextureHandle,
    size_px: [f64; 2],
    /// Where the left end of the base line is.
    origin_px: DVec2,
}

/// A frame of a window for which labels are laid out.
pub(super) struct LabelFrame<'a> {
    pub context: &'a egui::Context,
    /// The eyes of the frame, in pixels of the window.
    pub rig: &'a Rig,
    pub earth: EarthCurvature,
    pub ground: Ground<'a>,
    /// The eyes that are shown, and how far to the right each is in the window, in pixels.
    pub shown: &'a [(usize, f64)],
    pub ink: Color,
    /// Time since the flight began, in seconds.
    pub time_s: f64,
}

impl Labels {
    /// Creates the labels of a flight over a world. They are drawn if summits or places were asked for.
    pub(super) fn new(options: LabelOptions, world: Option<String>) -> Self {
        let now = Instant::now();
        Self {
            is_on: options.peaks.is_some() || !options.places.is_empty(),
            options,
            world,
            land: None,
            reading: None,
            sites: None,
            readback: Readback { queue: AsyncReadback::new(4), bytes: 4 },
            asked: None,
            looking: None,
            look: None,
            looked: 0,
            next_look: now,
            next_check: now,
            names: MovingNames::default(),
            drawn_with: None,
            last: Vec::new(),
            moves: false,
            letters: BTreeMap::new(),
            settles_until: now,
        }
    }

    /// Returns whether labels are drawn.
    pub(super) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Draws labels from now on, or no longer.
    pub(super) fn toggle(&mut self) {
        self.is_on = !self.is_on;
        self.forget();
        self.looked = 0;
        if self.options.peaks.is_none() && self.options.places.is_empty() {
            self.options.peaks = Some(PEAKS);
        }
    }

    fn forget(&mut self) {
        (self.look, self.asked, self.looking) = (None, None, None);
        self.moves = false;
        self.names = MovingNames::default();
        self.letters.clear();
        self.readback.queue.forget();
    }

    /// Begins to find the summits of a land whose summits are not known, and calls `wake` when they have been found.
    pub(super) fn follow(
        &mut self,
        terrain: &Terrain,
        exaggeration: f64,
        world: Option<&str>,
        wake: impl Fn() + Send + 'static,
    ) {
        let store = terrain.store();
        if !self.is_on || self.land.as_ref().is_some_and(|land| std::ptr::addr_eq(land.as_ptr(), Arc::as_ptr(store))) {
            return;
        }
        self.land = Some(Arc::downgrade(store));
        self.sites = None;
        self.forget();
        self.looked = 0;
        let is_of_places = self.world.as_deref() == world;
        let places = if is_of_places { self.options.places.clone() } else { Vec::new() };
        if !is_of_places && self.options.peaks.is_none() {
            self.options.peaks = Some(PEAKS);
        }
        let (ground, store, wide_m) = (terrain.ground_heights(), Arc::clone(store), terrain.extent_m()[0]);
        let find = move || {
            let ground_m = |at: DVec2| ground.height_m(at.x, at.y);
            let land = Land { store: &store, wide_m, exaggeration, ground_m: &ground_m };
            Sites::find(&land, &places, &Silent).map_err(|error| error.to_string())
        };
        self.reading = Some(Background::start("summits", find, wake));
    }

    /// Takes the summits that have been found, and what has been seen. Returns whether a frame is needed, or why there are
    /// no summits.
    ///
    /// # Errors
    /// The heights cannot be read.
    pub(super) fn take(&mut self, wake: impl Fn() + Send + 'static) -> Result<bool, String> {
        let mut has_news = false;
        if let Some(found) = self.reading.as_ref().and_then(Background::take) {
            self.reading = None;
            let found = found.unwrap_or_else(|NoResult| Err("the summits could not be found".to_owned()));
            self.sites = Some(Arc::new(found?));
            has_news = true;
        }
        if let Some(seen) = self.looking.as_ref().and_then(Background::take) {
            self.looking = None;
            if let Ok(Some(seen)) = seen {
                self.look = Some(seen);
                self.settles_until = Instant::now() + SETTLE;
                has_news = true;
            }
        }
        self.next_check = Instant::now() + ANSWER_CHECK;
        let Some(asked) = &mut self.asked else { return Ok(has_news) };
        asked.answers.extend(std::iter::from_fn(|| self.readback.queue.take()));
        if asked.answers.len() < asked.eyes.len() {
            if !self.readback.queue.is_waiting() {
                // The device dropped the rest.
                self.asked = None;
            }
            return Ok(has_news);
        }
        if let (Some(asked), Some(sites)) = (self.asked.take(), self.sites.clone()) {
            let held = self.names.held();
            let look = move || {
                let wanted = Wanted { sites: &sites.all, held: &held };
                asked.surface().map(|(surface, whole)| surface.visible(wanted, &whole))
            };
            self.looking = Some(Background::start("labels", look, wake));
        }
        Ok(has_news)
    }

    /// Requests the distances of the picture with a number, unless it has been looked at or another look is under way.
    /// `rig` has the eyes of the picture, and `whole` the same in pixels of the window.
    pub(super) fn request(
        &mut self,
        gpu: &Gpu,
        renderer: &Renderer,
        [rig, whole]: [Rig; 2],
        seen: (EarthCurvature, u64),
    ) {
        let (earth, picture) = seen;
        let now = Instant::now();
        if !self.wants_look(picture) || now < self.next_look {
            return;
        }
        let mut eyes = Vec::new();
        let mut targets = Vec::new();
        for (number, eye) in rig.eyes.iter().enumerate() {
            let Some(target) = renderer.eye_target(number, &DISTANCE) else { return };
            let row_bytes = (u64::from(target.texture.width()) * 4).next_multiple_of(ROW_BYTES);
            let bytes = row_bytes * u64::from(target.texture.height());
            if self.readback.bytes < bytes {
                self.readback = Readback { queue: AsyncReadback::new(bytes), bytes };
            }
            let (view, size_px) = (eye.uniform(rig.origin_m), target.size_px());
            eyes.push(AskedEye { view, size_px, row_bytes: row_bytes as usize });
            targets.push(target);
        }
        if targets.iter().all(|target| self.readback.queue.request_picture(gpu, &target.texture)) {
            self.asked = Some(Asked { eyes, answers: Vec::new(), rig, whole, earth });
            self.looked = picture;
            self.next_check = now + ANSWER_CHECK;
        }
        self.next_look = now + LOOK;
    }

    fn wants_look(&self, picture: u64) -> bool {
        let is_idle = self.asked.is_none() && self.looking.is_none();
        self.is_on && is_idle && self.sites.is_some() && self.looked != picture
    }

    /// Returns when to check for an answer, or to look at the picture with a number.
    pub(super) fn due_at(&self, picture: u64) -> Option<Instant> {
        let answer = self.asked.is_some().then_some(self.next_check);
        answer.or_else(|| self.wants_look(picture).then_some(self.next_look))
    }

    /// Returns whether the picture with a number is to be looked at now.
    pub(super) fn is_due(&self, picture: u64, now: Instant) -> bool {
        self.wants_look(picture) && self.next_look <= now
    }

    /// Returns whether labels may still fade or move without a new picture.
    pub(super) fn is_settling(&self, now: Instant) -> bool {
        self.is_on && self.look.is_some() && (self.moves || now < self.settles_until)
    }

    /// Lays out the labels of a frame, and returns what is painted.
    pub(super) fn shapes(&mut self, frame: &LabelFrame<'_>) -> Vec<Shape> {
        let (Some(sites), Some(look), true) = (self.sites.clone(), &self.look, self.is_on) else { return Vec::new() };
        let drawn_with = Some((frame.ground.paper.typeface, frame.ground.px, is_dark(frame.ink)));
        if self.drawn_with != drawn_with {
            self.drawn_with = drawn_with;
            self.letters.clear();
            self.names = MovingNames::default();
        }
        let now = |seen: &[_]| -> Vec<_> { seen.iter().filter_map(|at| frame.follow(at, &sites.all)).collect() };
        let visible = Visible { sites: now(&look.sites), hidden: now(&look.hidden), land_top_px: look.land_top_px };
        let most = self.options.peaks.unwrap_or(0);
        let placed = self.names.frame(frame.time_s, &sites, &visible, most, &frame.ground);
        let state = |label: &Placed| (label.at.site, [label.opacity, label.offset_px, label.bottom_px]);
        let last = std::mem::replace(&mut self.last, placed.iter().map(state).collect());
        // However long a frame takes, a label that fades is painted until it has faded.
        self.moves = last != self.last || placed.iter().any(|label| label.opacity < 1.0);
        if self.moves {
            self.settles_until = Instant::now() + SETTLE;
        }
        let is_there = |site: &usize| placed.iter().any(|label| label.at.site == *site);
        self.letters.retain(|site, _| is_there(site));
        let mut halos = Vec::new();
        let mut shapes = Vec::new();
        for label in &placed {
            let site = label.at.site;
            let make = || Letters::new(frame, &sites.all[site].text);
            let letters = self.letters.entry(site).or_insert_with(make);
            for (eye, right_px) in frame.shown {
                letters.paint(label, (*eye, *right_px), frame, (&mut halos, &mut shapes));
            }
        }
        halos.append(&mut shapes);
        halos
    }
}

impl Asked {
    /// Returns the surface that the eyes saw, and the eyes in the window.
    fn surface(self) -> Option<(SeenSurface, Rig)> {
        let distances = self.eyes.iter().zip(&self.answers).map(|(eye, bytes)| {
            let [width, height] = eye.size_px.map(|side| side as usize);
            let rows = bytes.chunks_exact(eye.row_bytes).take(height);
            let numbers = rows.flat_map(|row| row.as_chunks::<4>().0.iter().take(width));
            SeenDistances::new(eye.view, eye.size_px, numbers.map(|number| f32::from_le_bytes(*number)).collect())
        });
        let distances = distances.collect::<Option<Vec<_>>>()?;
        Some((SeenSurface::new(&self.rig, self.earth, distances)?, self.whole))
    }
}

impl LabelFrame<'_> {
    /// Returns where a site is in this frame.
    fn follow(&self, at: &Seen, sites: &[Site]) -> Option<Seen> {
        let (px, apart_px) = placed_on(self.rig, &self.earth, sites[at.site].world_m)?;
        Some(Seen { px, apart_px, ..*at })
    }
}

impl Letters {
    fn new(frame: &LabelFrame<'_>, text: &str) -> Self {
        let LetterMask { size_px, ink, halo, origin_px } = letter_mask(text, &frame.ground);
        let texture = |covered: &[f32], color: Color| {
            let white = |part: &f32| Color32::from_white_alpha((255.0 * alpha(*part, is_dark(color))).round() as u8);
            let size = size_px.map(|side| side as usize);
            let image = ColorImage::new(size, covered.iter().map(white).collect());
            frame.context.load_texture("label", image, TextureOptions::LINEAR)
        };
        let (ink, halo) = (texture(&ink, frame.ink), texture(&halo, frame.ground.paper.color));
        Self { ink, halo, size_px: size_px.map(f64::from), origin_px }
    }

    /// Paints a label on the picture of an eye, which is `right_px` to the right in the window.
    fn paint(
        &self,
        label: &Placed,
        (eye, right_px): (usize, f64),
        frame: &LabelFrame<'_>,
        (halos, shapes): (&mut Vec<Shape>, &mut Vec<Shape>),
    ) {
        let points = f64::from(frame.context.pixels_per_point());
        let point = |px: DVec2| pos2((px.x / points) as f32, (px.y / points) as f32);
        let parallax_px = if eye == 1 { label.at.apart_px } else { 0.0 };
        let px = frame.ground.px;
        let summit_px = (label.at.px + DVec2::new(right_px + parallax_px, 0.0)).round();
        let corner_px = (DVec2::new(summit_px.x + label.offset_px, label.bottom_px) - self.origin_px).round();
        let size = vec2((self.size_px[0] / points) as f32, (self.size_px[1] / points) as f32);
        let area = egui::Rect::from_min_size(point(corner_px), size);
        let tint = |color: Color| {
            let [red, green, blue] = color.srgb().map(|part| (255.0 * part).round() as u8);
            Color32::from_rgb(red, green, blue).gamma_multiply(label.opacity as f32)
        };
        let uv = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        if label.has_halo {
            halos.push(Shape::image(self.halo.id(), area, uv, tint(frame.ground.paper.color)));
        }
        let ends = [label.bottom_px + LETTER_GAP * px, summit_px.y - LETTER_GAP * px];
        if ends[1] > ends[0] {
            let line = ends.map(|y| point(DVec2::new(summit_px.x + 0.5, y)));
            // A line narrower than a pixel is a pale one of a pixel.
            let width_px = leader_px(px);
            let pale = alpha(width_px.min(1.0) as f32, is_dark(frame.ink));
            let stroke = egui::Stroke::new((width_px.max(1.0) / points) as f32, tint(frame.ink).gamma_multiply(pale));
            shapes.push(Shape::line_segment(line, stroke));
        }
        shapes.push(Shape::image(self.ink.id(), area, uv, tint(frame.ink)));
    }
}

/// Returns whether a colour is darker than what it is usually drawn on.
fn is_dark(color: Color) -> bool {
    let [red, green, blue] = color.linear();
    0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.18
}

/// Returns the opacity in sRGB, in which egui mixes colours, of what covers a part of a pixel in linear light.
fn alpha(covered: f32, is_dark: bool) -> f32 {
    let covered = covered.clamp(0.0, 1.0);
    if is_dark { 1.0 - srgb_from_linear(1.0 - covered) } else { srgb_from_linear(covered) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_as_dark_as_in_a_picture() {
        for covered in [0.0, 0.2, 0.5, 0.9, 1.0] {
            // Black on white, mixed in linear light, and by egui.
            let expected = srgb_from_linear(1.0 - covered);
            let found = 1.0 - alpha(covered, true);
            assert!((found - expected).abs() < 1e-6);
            let expected = srgb_from_linear(covered);
            assert!((alpha(covered, false) - expected).abs() < 1e-6);
        }
        // Planted: the coverage itself.
        assert!((alpha(0.5, true) - 0.5).abs() > 0.2);
        assert!(is_dark(Color::from_srgb([0.1; 3])) && !is_dark(Color::WHITE));
    }
}
