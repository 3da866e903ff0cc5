//! `render --title`: adds a block of text below the picture.

use glam::DVec2;

use super::map::PlacedMap;
use super::{Job, RenderArgs};
use crate::commands::misuse::Misuse;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::picture::legend::{self, Legend};
use crate::picture::map_frame::{self, Coordinates, MapFrame};
use crate::picture::title::{Block, MapScale, Words, block, foot_px, grouped};
use crate::scene::view::Pose;
use crate::source::georeference::Crs;
use crate::style::{Paper, Style, Typeface};
use crate::vector::Group;

/// Largest number of characters that a warning lists.
const MAX_NAMED: usize = 30;

const COMPASS: [&str; 16] =
    ["N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"];

/// Returns the style with paper for the frame of a map and for the title block, where they are drawn.
///
/// # Errors
/// Fails if the picture is too small or cannot have a title block.
pub(super) fn with_foot(mut style: Style, args: &RenderArgs, kind: &OutputKind) -> Result<Style, Misuse> {
    if args.pens.is_some() {
        style.paper.typeface = Typeface::Strokes;
    }
    if args.frame {
        let ink = style.lettering_ink();
        map_frame::set_paper(&mut style.paper, ink, args.px_per_style_px());
        let [width, height] = args.size();
        let least_px = 4 * map_frame::edge_px(&style.paper);
        if width.min(height) < least_px {
            return Err(Misuse(format!(
                "--map-frame: a picture of {width}x{height} px is too small for a frame; it must have at least \
                 {least_px}x{least_px} px"
            )));
        }
    }
    if args.title.is_none() {
        return match (&args.credits, args.legend) {
            (Some(_), _) => Err(Misuse("--credits: are part of the title block; add --title TEXT".to_owned())),
            (None, true) => Err(Misuse("--legend: is part of the title block; add --title TEXT".to_owned())),
            (None, false) => Ok(style),
        };
    }
    if args.credits.as_ref().is_some_and(|credits| credits.trim().is_empty()) {
        return Err(Misuse("--credits: the text is empty; leave the option out".to_owned()));
    }
    let output = named(&args.output);
    if matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) {
        return Err(Misuse(format!("--title: a .geojson has no title block, and the output is {output}")));
    }
    if kind.is_drawing() && args.stereo.eyes().are_merged() {
        let holder = kind.lines_name();
        return Err(Misuse(format!("--title: an anaglyph in {holder} has no title block; write a .png")));
    }
    // Coordinates are between a framed map and the block.
    let margin_px = if args.frame { 0.0 } else { style.paper.margin_px };
    let paper = Paper { margin_px, ..style.paper.clone() };
    let px = args.px_per_style_px();
    let legend_rows = legend_rows(&style, args)?;
    style.paper.foot_px = foot_px(&paper, args.credits.is_some(), legend_rows, px);
    let [width, height] = args.size();
    let taken_px = style.paper.foot_px + 2.0 * style.paper.margin_px;
    if taken_px > 0.5 * height as f32 || width < 64 {
        return Err(Misuse(format!(
            "--title: a picture of {width}x{height} px is too small for a title block, which takes {taken_px:.0} px of \
             its height, with credits, legend, the frame of a map and margins"
        )));
    }
    Ok(style)
}

/// Returns the number of rows for which a title block has space for a legend; 0 without a legend.
fn legend_rows(style: &Style, args: &RenderArgs) -> Result<usize, Misuse> {
    if !args.legend {
        return Ok(0);
    }
    let shown = if args.map.is_some() { style.clone().for_map(1.0).map_err(Misuse::of)? } else { style.clone() };
    let side_px = if style.paper.margin_px > 0.0 { f64::from(style.paper.margin_px) } else { 16.0 };
    let room_px = f64::from(args.size()[0]) / args.px_per_style_px() - 2.0 * side_px / args.px_per_style_px();
    Ok(legend::most_rows(&shown, room_px))
}

impl Job<'_> {
    /// Returns the title block of an eye's picture, if there is a title.
    pub(super) fn title_block(&self, pose: &Pose) -> Option<Block> {
        let titled = self.args.title.clone().map(|title| self.titled(title, pose));
        let Some(map) = self.map.as_ref().filter(|_| self.args.frame) else { return titled };
        let mut block = titled.unwrap_or_else(|| Block::empty(self.style.lettering_ink()));
        let MapFrame { strokes, areas, texts, .. } = self.frame(map);
        block.strokes.extend(strokes);
        block.areas.extend(areas);
        block.texts.extend(texts);
        Some(block)
    }

    /// Returns the legend before anything of the picture has been seen, if there is one.
    pub(super) fn legend(&self) -> Option<Legend> {
        let exaggeration = self.world.scene.vertical_exaggeration;
        self.args.legend.then(|| Legend::new(&self.style, exaggeration))
    }

    /// Returns the frame of a map.
    fn frame(&self, map: &PlacedMap) -> MapFrame {
        let terrain = &self.world.surfaces.terrain;
        let mapping = terrain.mapping();
        let crs = &terrain.store().georeference().crs;
        let (kind, unit) = match crs {
            Crs::Geographic { radians_per_unit, .. } => (Coordinates::Degrees, radians_per_unit.to_degrees()),
            Crs::Projected { .. } | Crs::Local => (Coordinates::Lengths, 1.0),
        };
        let coordinates = |px: DVec2| {
            let world_m = map.map.world_from_px(px);
            if *crs == Crs::Local { world_m } else { mapping.crs_from_world(world_m) * unit }
        };
        map_frame::map_frame(self.args.size(), &self.style.paper, kind, coordinates, self.args.px_per_style_px())
    }

    fn titled(&self, title: String, pose: &Pose) -> Block {
        let style = &self.style;
        let (below, scale) = match &self.map {
            Some(map) => {
                let mm_per_px = super::paper::mm_per_px(self.args, self.svg.as_ref());
                let mapping = self.world.surfaces.terrain.mapping();
                let middle_m = map.map.world_from_px(0.5 * map.map.size());
                let true_north_rad = mapping.true_north_rad(middle_m);
                let scale =
                    MapScale { m_per_px: map.map.pixel_m, mm_per_px, denominator: self.args.map_scale, true_north_rad };
                // The code of the picture's reference system; a picture in the world's own projection has none.
                let code = map.georeference.epsg().map(|code| format!("EPSG:{code} · ")).unwrap_or_default();
                let width_px = f64::from(self.args.size()[0]) / self.args.px_per_style_px();
                let convergence = convergence(true_north_rad, width_px < NARROW_PX);
                let interval = style.lowest_height_lines().map_or(0.0, |lines| lines.interval_m);
                let interval = match interval {
                    // The legend says so.
                    _ if self.args.legend => String::new(),
                    0.0 => String::new(),
                    whole if whole.fract() == 0.0 => format!("contour lines every {} m · ", grouped(whole.into())),
                    other => format!("contour lines every {other} m · "),
                };
                let coordinates = if self.args.frame { self.coordinates() } else { String::new() };
                (format!("{code}{convergence}{interval}{coordinates}{}", style.name), Some(scale))
            }
            None => (format!("{} · {}", self.seen_from(pose), style.name), None),
        };
        let credits = self.args.credits.clone().unwrap_or_default();
        // A style that can be drawn can be drawn on a map.
        let legend_rows = legend_rows(style, self.args).unwrap_or_default();
        let words = Words { title, below, credits, scale, legend_rows };
        block(&words, self.args.size(), &style.paper, style.lettering_ink(), self.args.px_per_style_px())
    }

    /// Returns the words of a title block about the coordinates of a frame; degrees need none.
    fn coordinates(&self) -> String {
        match &self.world.surfaces.terrain.store().georeference().crs {
            Crs::Geographic { .. } => String::new(),
            Crs::Local => "coordinates in m · ".to_owned(),
            Crs::Projected { metres_per_unit, name } => {
                let unit = match *metres_per_unit {
                    1.0 => "m",
                    1000.0 => "km",
                    feet if (feet - 0.3048).abs() < 1e-4 => "ft",
                    _ => "units",
                };
                format!("coordinates in {unit} of {name} · ")
            }
        }
    }

    /// Warns if a legend has no entry.
    pub(super) fn warn_of_legend(&self, legend: &Legend) {
        if legend.is_empty() {
            let output = named(&self.args.output);
            tracing::warn!("--legend: {output} shows no lines or areas that a legend explains, so it has none");
        }
    }

    /// Warns once if the frame of a map states no coordinates.
    pub(super) fn warn_of_frame(&self) {
        let Some(map) = self.map.as_ref().filter(|_| self.args.frame) else { return };
        if self.frame(map).labels == 0 {
            let output = named(&self.args.output);
            tracing::warn!("--map-frame: {output} is too small, or shows too little land, for round coordinates");
        }
    }

    /// Warns once about characters that neither the lettering nor a font of the machine has.
    pub(super) fn warn_of_letters(&self, pose: &Pose) {
        let replaced = self.title_block(pose).map(|block| block.replaced).unwrap_or_default();
        warn_of_replaced("title block", &replaced);
    }

    /// Adds the title block and the frame of a map to the lines of a drawing.
    pub(super) fn add_title(&self, groups: &mut Vec<Group>, pose: &Pose) {
        let title = self.args.title.clone().map(|title| ("title", "Title block", self.titled(title, pose)));
        let frame = self.map.as_ref().filter(|_| self.args.frame).map(|map| {
            let MapFrame { strokes, areas, texts, .. } = self.frame(map);
            ("frame", "Frame of the map", Block { strokes, areas, texts, ..Block::empty(self.style.lettering_ink()) })
        });
        let is_for_pens = self.args.pens.is_some();
        let all = title.into_iter().chain(frame);
        let mut drawn = Vec::new();
        for (id, label, block) in all {
            let mut legend = self.legend().filter(|_| block.legend.is_some());
            if let Some(legend) = &mut legend {
                legend.look_in(groups);
                self.warn_of_legend(legend);
            }
            drawn.push(block.group((id, label), is_for_pens));
            let samples = legend.zip(block.legend).map(|(legend, place)| legend.blocks(&place)).unwrap_or_default();
            for (number, sample) in (1..).zip(samples) {
                drawn.push(sample.group((&format!("legend-{number}"), "Legend"), is_for_pens));
            }
        }
        groups.extend(drawn.into_iter().filter(|group| !group.lines.is_empty() || !group.fills.is_empty()));
    }

    /// Describes where the camera is, as in `46.5312° N 7.9620° E, height 2 350 m, looking SW (220°)`.
    fn seen_from(&self, pose: &Pose) -> String {
        let terrain = &self.world.surfaces.terrain;
        let at_m = pose.position_m;
        let crs = terrain.mapping().crs_from_world(DVec2::new(at_m.x, at_m.y));
        let place = match &terrain.store().georeference().crs {
            Crs::Geographic { radians_per_unit, .. } => {
                let [east, north] = [crs.x, crs.y].map(|angle| (angle * radians_per_unit).to_degrees());
                let east = (east + 180.0).rem_euclid(360.0) - 180.0;
                let side = |angle: f64, sides: [&'static str; 2]| if angle < 0.0 { sides[1] } else { sides[0] };
                let (n, e) = (side(north, ["N", "S"]), side(east, ["E", "W"]));
                format!("{:.4}° {n} {:.4}° {e}", north.abs(), east.abs())
            }
            Crs::Projected { .. } => format!("E {}, N {}", grouped(crs.x), grouped(crs.y)),
            Crs::Local => format!("x {} m, y {} m", grouped(at_m.x), grouped(at_m.y)),
        };
        let true_north_deg = terrain.mapping().true_north_rad(at_m.truncate()).unwrap_or(0.0).to_degrees();
        let heading_deg = (pose.yaw_deg() - true_north_deg).rem_euclid(360.0);
        let name = COMPASS[(heading_deg / 22.5).round() as usize % COMPASS.len()];
        format!("{place}, height {} m, looking {name} ({:.0}°)", grouped(at_m.z), heading_deg.round() % 360.0)
    }
}

/// Warns about characters of a text that neither the lettering nor a font of the machine has.
pub(super) fn warn_of_replaced(what: &str, replaced: &[char]) {
    if replaced.is_empty() {
        return;
    }
    let mut letters = replaced.to_vec();
    letters.sort_unstable();
    letters.dedup();
    let named = letters.iter().take(MAX_NAMED).map(|letter| letter.escape_debug().to_string());
    let mut list = named.collect::<Vec<_>>().join(" ");
    if letters.len() > MAX_NAMED {
        list += &format!(" and {} more", letters.len() - MAX_NAMED);
    }
    tracing::warn!("{what}: no font on this machine has these characters, drawn as question marks: {list}");
}

/// Smallest convergence of the meridians that a title block states, in degrees.
const STATED_CONVERGENCE_DEG: f64 = 0.5;

/// Width below which a title block is abbreviated, in pixels of the style.
const NARROW_PX: f64 = 800.0;

/// Returns the text of a title block about the angle between the top of the sheet and true north, abbreviated if the
/// block `is_narrow`; empty if the angle is small.
fn convergence(true_north_rad: Option<f64>, is_narrow: bool) -> String {
    match true_north_rad.map(f64::to_degrees) {
        None if is_narrow => "grid N up · ".to_owned(),
        None => "grid north up · ".to_owned(),
        Some(deg) if deg.abs() <= STATED_CONVERGENCE_DEG => String::new(),
        // True north to the right of grid north means that grid north is west of it.
        Some(deg) => {
            let side = if deg > 0.0 { "W" } else { "E" };
            if is_narrow {
                return format!("grid N {:.1}° {side} · ", deg.abs());
            }
            format!("grid north {:.1}° {side} of true north · ", deg.abs())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn convergence_is_stated_beyond_half_a_degree() {
        let text = |deg: f64| convergence(Some(deg.to_radians()), false);
        assert_eq!(text(30.9), "grid north 30.9° W of true north · ");
        assert_eq!(text(-2.04), "grid north 2.0° E of true north · ");
        assert_eq!([text(0.4), text(-0.5)], ["", ""]);
        assert_eq!(convergence(None, false), "grid north up · ");
        assert_eq!(convergence(Some(-0.0157), true), "grid N 0.9° E · ");
        assert_eq!(convergence(Some(0.0), true), "");
    }
}
