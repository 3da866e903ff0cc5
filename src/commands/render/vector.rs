//! `hachure render -o out.svg`: writes the strokes and marks of a picture as paths; a map can also become GeoJSON.

use std::path::Path;

use anyhow::Context;

use super::super::misuse::Misuse;
use super::names::NAMES;
use super::numbers::groups_px;
use super::paper::{MARGIN_MM, MM_PER_INCH};
use super::{Job, RenderArgs};
use crate::file::message::{counted, named, shown};
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::pdf::write_pdf;
use crate::file::svg::{self, Drawing, Layer, Unit};
use crate::picture::contour_numbers::Numbers;
use crate::picture::strokes::{has_marks, render_strokes};
use crate::picture::{PictureReport, PictureRequest};
use crate::scene::stereo::Eyes;
use crate::scene::view::Pose;
use crate::style::layers::{Layer as StyleLayer, Trace};
use crate::style::{Style, StyleInk};
use crate::vector::pens::Pens;
use crate::vector::sheet::Sheet;
use crate::vector::{self, DrawingReport, Group, Settings, TOLERANCE_PX};

/// A layer of an anaglyph: id, label and ink. A red glass shows cyan as black, and red as paper.
type EyeInk = (&'static str, &'static str, &'static str);
const LEFT_INK: EyeInk = ("left-eye", "Left eye, for a red glass", "#00ffff");
const RIGHT_INK: EyeInk = ("right-eye", "Right eye, for a cyan glass", "#ff0000");
/// Id and label of the layer with the numbers on contour lines.
const NUMBERS: (&str, &str) = ("contour-numbers", "Numbers on contour lines");
const DEPTHS: (&str, &str) = ("depth-numbers", "Numbers on depth contours");
/// Id and label of the layer with their halo. A pen has no ink of the colour of paper.
const NUMBERS_HALO: (&str, &str) = ("contour-numbers-halo", "Halo of numbers on contour lines");

/// Options of an SVG, or of a GeoJSON, whose lines are in pixels until they are georeferenced.
pub(super) struct SvgOptions {
    settings: Settings,
    /// Number of pens; `None` if paths have the widths and opacities of the picture.
    pens: Option<usize>,
}

impl SvgOptions {
    /// Returns `None` if the output has no lines.
    ///
    /// # Errors
    /// Fails for a style without strokes and marks, and for a tolerance, paper or margin that is invalid or does not
    /// apply to the output.
    pub(super) fn new(args: &RenderArgs, kind: &OutputKind, style: &Style) -> anyhow::Result<Option<Self>> {
        let output = named(&args.output);
        let is_on_earth = matches!(kind, OutputKind::Picture(PictureFormat::GeoJson));
        let is_svg = kind.is_drawing();
        if !is_svg {
            let given = [
                ("--margin", args.margin.is_some(), "an .svg or .pdf"),
                ("--tolerance-px", args.tolerance_px.is_some() && !is_on_earth, "an .svg, .pdf or .geojson"),
                ("--pens", args.pens.is_some() && !is_on_earth, "an .svg, .pdf or .geojson"),
            ];
            if let Some((option, _, outputs)) = given.into_iter().find(|(_, is_given, _)| *is_given) {
                return Err(Misuse(format!("{option}: applies only to {outputs}, and the output is {output}")).into());
            }
        }
        if !is_svg && !is_on_earth {
            return Ok(None);
        }
        // Shores and water lines alone are not a drawing.
        let mut inks = style.inks().into_iter().rev();
        let is_drawing = |own: &StyleInk| own.ink.is_main && !matches!(own.ink.trace, Trace::LeftOut(_));
        let Some(ink) = inks.find(is_drawing).map(|own| own.color) else {
            let style = shown(&style.name);
            let ending = kind.lines_name();
            let misuse = format!(
                "{output}: {ending} holds strokes and marks, and the style {style} has none; try --style strokes"
            );
            return Err(Misuse(misuse).into());
        };
        if args.pens.is_some() && args.stereo.eyes().are_merged() {
            return Err(Misuse(
                "--pens: cannot be used with an anaglyph, which is drawn in the inks of its two glasses".into(),
            )
            .into());
        }
        let tolerance_px = args.tolerance_px.unwrap_or(TOLERANCE_PX * args.px_per_style_px());
        if is_on_earth {
            // Half of the tolerance is for fitting curves, half for flattening them into lines.
            let (tolerance_px, sheet) = (0.5 * tolerance_px, Sheet::pixels(args.size()));
            return Ok(Some(Self { settings: Settings { tolerance_px, sheet, ink }, pens: args.pens }));
        }
        let sheet = match (&args.paper, args.margin) {
            (Some(paper), margin) => Sheet::paper(paper, margin.unwrap_or(MARGIN_MM), args.size()).map_err(Misuse)?,
            (None, Some(margin)) => {
                return Err(Misuse(format!("--margin {margin}: requires --paper, which is not given")).into());
            }
            (None, None) => match args.dpi {
                Some(dpi) => Sheet::dots(args.size(), MM_PER_INCH / dpi),
                None => Sheet::pixels(args.size()),
            },
        };
        Ok(Some(Self { settings: Settings { tolerance_px, sheet, ink }, pens: args.pens }))
    }

    /// Returns width and height of the drawing on paper, in millimetres.
    pub(super) fn size_mm(&self) -> Option<[f64; 2]> {
        (self.settings.sheet.unit == Unit::Mm).then_some(self.settings.sheet.size)
    }

    /// Returns the side of a pixel on paper, in millimetres.
    pub(super) fn mm_per_px(&self) -> Option<f64> {
        (self.settings.sheet.unit == Unit::Mm).then_some(self.settings.sheet.units_per_px)
    }

    /// Returns how far flattened lines may be from their curves, in pixels.
    pub(super) fn flattening_px(&self) -> f64 {
        self.settings.tolerance_px
    }

    /// Returns the colour of lines without one of their own.
    pub(super) fn ink(&self) -> String {
        self.settings.ink.to_string()
    }

    /// Returns the report as a line of text. Lines on the earth (`is_on_earth`) have no pen that moves between them.
    pub(super) fn summary(&self, drawn: &DrawingReport, is_on_earth: bool) -> String {
        let sheet = &self.settings.sheet;
        let unit = sheet.unit.name();
        let length = |px: f64| px * sheet.units_per_px;
        let kinds: Vec<String> = drawn.kinds().map(|(count, name)| counted(count, name)).collect();
        let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
        let strokes = format!("{}{kinds} of {}", counted(drawn.strokes, "stroke"), counted(drawn.segments, "segment"));
        let pens: Vec<String> = drawn.pens.iter().map(|width| format!("{width:.2}")).collect();
        let pens = if pens.is_empty() { String::new() } else { format!("; pens of {} {unit}", pens.join(", ")) };
        if is_on_earth {
            return strokes + &pens;
        }
        format!(
            "{strokes}; pen down {:.0} {unit}, pen up {:.0} {unit} ({:.0} {unit} before ordering){pens}",
            length(drawn.pen_down_px),
            length(drawn.pen_up_px),
            length(drawn.pen_up_unordered_px)
        )
    }
}

/// Returns which parts of a style's pictures an SVG leaves out, as text; `None` if it leaves out nothing.
pub(super) fn left_out(style: &Style, eyes: Eyes) -> Option<String> {
    let of_layers = style.inks().into_iter().filter_map(|own| match own.ink.trace {
        Trace::LeftOut(part) => Some(part),
        _ => None,
    });
    let of_kinds = style.layers.iter().filter_map(|layer| layer.behaviour().missing_in_vectors());
    let of_style = [
        ("tones", style.tone.is_seen()),
        ("watercolour", style.watercolor.is_some()),
        ("sky colours", style.sky.is_drawn() && style.sky.has_colors()),
        ("sun and clouds without outline", style.sky.has_unlined_fills()),
        ("stars", style.sky.stars > 0.0),
        ("marks", !eyes.of_pair().is_empty() && has_marks(style)),
    ];
    let of_style = of_style.iter().filter(|(_, is_there)| *is_there).map(|(name, _)| *name);
    let parts: Vec<&str> = of_layers.chain(of_kinds).chain(of_style).collect();
    let (last, others) = parts.split_last()?;
    Some(if others.is_empty() { (*last).to_owned() } else { format!("{} and {last}", others.join(", ")) })
}

impl Job<'_> {
    /// Returns whether a drawing of lines on paper lacks the tints of areas. Those on the earth are outlines.
    pub(super) fn leaves_out_tints(&self) -> bool {
        let (Some(_), Some(features)) = (&self.svg, self.world.surfaces.features()) else { return false };
        let has_tint = |layer: &StyleLayer| match layer {
            StyleLayer::Features(layer) => layer.has_tint() && features.fills_any(layer),
            _ => false,
        };
        self.style.layers.iter().any(has_tint)
    }

    /// Draws the strokes and marks of a picture for `path`; a drawing on paper gets its border, a georeferenced one
    /// does not.
    pub(super) fn layers(
        &mut self,
        path: &Path,
        pose: Pose,
        is_on_earth: bool,
    ) -> anyhow::Result<(Vec<Layer>, DrawingReport, PictureReport)> {
        let mut labels = if is_on_earth { Vec::new() } else { self.label_groups(pose)? };
        let Some(SvgOptions { settings, pens }) = &self.svg else { unreachable!("created for this output") };
        // Lines that hatch areas are no features of the earth.
        let style = self.style.clone().without_area_tints(!is_on_earth);
        let still = PictureRequest::still(pose, self.args.size(), &style, self.world.light());
        // A geographic file has no letters, so its lines need no gaps for them.
        let numbers = if is_on_earth { None } else { self.contour_numbers(&groups_px(labels.iter().flatten()))? };
        let line_gaps = numbers.as_ref().map(Numbers::gaps).unwrap_or_default();
        let request = PictureRequest { clock: self.clock, tone_curve: self.tone_curve, line_gaps: &line_gaps, ..still };
        let (gpu, renderer, surfaces) = (&self.gpu, &mut self.renderer, &mut self.world.surfaces);
        let lines = render_strokes(gpu, renderer, surfaces, &request, self.pair.as_ref())
            .with_context(|| format!("cannot write {}", named(path)))?;
        let report = self.whole(lines.report)?;
        let (layers, drawn) = match (self.args.stereo.eyes(), lines.strokes.as_slice()) {
            (Eyes::Anaglyph | Eyes::GreyAnaglyph, [left, right]) => {
                let (left, mut drawn) = vector::layer_of_eye(left, settings, LEFT_INK);
                let (right, of_right) = vector::layer_of_eye(right, settings, RIGHT_INK);
                drawn.append(&of_right);
                let mut layers = vec![left, right];
                for (labels, (id, label, ink)) in labels.iter().zip([LEFT_INK, RIGHT_INK]) {
                    let letters = labels.iter().filter(|group| group.id == NAMES);
                    let named = letters.map(|group| Group {
                        id: format!("{}-{id}", group.id),
                        label: format!("{}. {label}", group.label),
                        ..group.clone()
                    });
                    let (of_labels, report) = vector::layers(&named.collect::<Vec<_>>(), settings, None);
                    layers.extend(of_labels.into_iter().map(|layer| Layer { ink: Some(ink.to_owned()), ..layer }));
                    drawn.append(&report);
                }
                (layers, drawn)
            }
            (shown, eyes) => {
                let eye = usize::from(shown == Eyes::Right && eyes.len() > 1);
                let strokes = eyes.get(eye).map_or(&[][..], Vec::as_slice);
                let stroke_ink = self.style.strokes().map_or(settings.ink, |strokes| strokes.ink);
                let mut groups = lines.marks;
                groups.extend(vector::groups(strokes, stroke_ink));
                groups.extend(lines.marks_above);
                if let Some(numbers) = &numbers {
                    let halo = numbers.halo().filter(|_| pens.is_none()).map(|halo| halo.group(NUMBERS_HALO, false));
                    let letters = numbers
                        .letters()
                        .into_iter()
                        .map(|(is_depth, block)| block.group(if is_depth { DEPTHS } else { NUMBERS }, pens.is_some()));
                    let drawn = halo.into_iter().chain(letters);
                    groups.extend(drawn.filter(|group| !group.lines.is_empty() || !group.fills.is_empty()));
                }
                if !is_on_earth {
                    vector::border::bordered(&mut groups, &self.style.paper, self.args.size());
                }
                groups.extend((eye < labels.len()).then(|| labels.swap_remove(eye)).into_iter().flatten());
                if !is_on_earth {
                    self.add_title(&mut groups, &pose);
                }
                let pens = pens.map(|count| Pens::chosen(count, groups.iter().flat_map(|group| &group.lines)));
                vector::layers(&groups, settings, pens.as_ref())
            }
        };
        Ok((layers, drawn, report))
    }

    /// Writes the strokes and marks of a picture to `path`, an SVG or a PDF.
    pub(super) fn lines(&mut self, path: &Path, format: PictureFormat, pose: Pose) -> anyhow::Result<PictureReport> {
        let (layers, drawn, report) = self.layers(path, pose, false)?;
        let Some(SvgOptions { settings, .. }) = &self.svg else { unreachable!("created for this output") };
        let [width, height] = self.args.size();
        let drawing = Drawing {
            title: format!("hachure: {}", self.style.name),
            description: format!(
                "Strokes and marks of the style {}, {width}x{height} px, camera {}. Curves are within {} px of the strokes. Pen \
                 down {:.0} px, pen up {:.0} px.",
                self.style.name,
                self.camera_text(pose),
                settings.tolerance_px,
                drawn.pen_down_px,
                drawn.pen_up_px
            ),
            size: settings.sheet.size,
            unit: settings.sheet.unit,
            digits: settings.digits(),
            ink: settings.ink.to_string(),
            layers,
        };
        self.svg_sheets(&drawing)?;
        let imprint = self.imprint_text();
        match format {
            PictureFormat::Pdf => write_pdf(path, &drawing, Some(&imprint))?,
            _ => svg::write_svg(path, &drawing, Some(&imprint))?,
        }
        self.drawn.append(&drawn);
        Ok(report)
    }
}
