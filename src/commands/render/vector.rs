//! `hachure render -o out.svg`: the strokes of a picture as paths.

use std::path::Path;

use anyhow::Context;

use super::super::misuse::Misuse;
use super::paper::{MARGIN_MM, MM_PER_INCH};
use super::{Job, RenderArgs};
use crate::file::message::{named, shown};
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::svg::{self, Drawing, Unit};
use crate::picture::strokes::render_strokes;
use crate::picture::{PictureReport, PictureRequest};
use crate::scene::stereo::Eyes;
use crate::scene::view::Pose;
use crate::style::Style;
use crate::vector::sheet::Sheet;
use crate::vector::{self, DrawingReport, Settings, TOLERANCE_PX};

/// A layer of an anaglyph: its name, what it is, and its ink. Red glass shows cyan as black, and red as paper.
type EyeInk = (&'static str, &'static str, &'static str);
const LEFT_INK: EyeInk = ("left-eye", "Left eye, for a red glass", "#00ffff");
const RIGHT_INK: EyeInk = ("right-eye", "Right eye, for a cyan glass", "#ff0000");

/// What the options say of an SVG.
pub(super) struct SvgOptions(Settings);

impl SvgOptions {
    /// None if the output is no SVG.
    ///
    /// # Errors
    /// A style without strokes; a tolerance, paper or margin that makes no sense, or of another output.
    pub(super) fn new(args: &RenderArgs, kind: &OutputKind, style: &Style) -> anyhow::Result<Option<Self>> {
        let output = named(&args.output);
        if !matches!(kind, OutputKind::Picture(PictureFormat::Svg) | OutputKind::Frames(_, PictureFormat::Svg)) {
            let given = [("--tolerance-px", args.tolerance_px.is_some()), ("--margin", args.margin.is_some())];
            if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
                return Err(Misuse(format!("{option}: only an .svg has it, and the output is {output}")).into());
            }
            return Ok(None);
        }
        let Some(strokes) = &style.strokes else {
            let style = shown(&style.name);
            let misuse =
                format!("{output}: an .svg holds strokes, and the style {style} has none; --style strokes has");
            return Err(Misuse(misuse).into());
        };
        let tolerance_px = args.tolerance_px.unwrap_or(TOLERANCE_PX * args.px_per_style_px());
        let sheet = match (&args.paper, args.margin) {
            (Some(paper), margin) => Sheet::paper(paper, margin.unwrap_or(MARGIN_MM), args.size()).map_err(Misuse)?,
            (None, Some(margin)) => {
                return Err(Misuse(format!("--margin {margin}: it is a margin of --paper, which is not given")).into());
            }
            (None, None) => match args.dpi {
                Some(dpi) => Sheet::dots(args.size(), MM_PER_INCH / dpi),
                None => Sheet::pixels(args.size()),
            },
        };
        Ok(Some(Self(Settings { tolerance_px, sheet, ink: strokes.ink })))
    }

    /// The length of a pixel on paper.
    pub(super) fn mm_per_px(&self) -> Option<f64> {
        (self.0.sheet.unit == Unit::Mm).then_some(self.0.sheet.units_per_px)
    }

    /// The report in a line.
    pub(super) fn told(&self, drawn: &DrawingReport) -> String {
        let sheet = &self.0.sheet;
        let unit = sheet.unit.name();
        let length = |px: f64| px * sheet.units_per_px;
        format!(
            "{} strokes ({} contours, {} borders, {} creases) of {} segments; pen down {:.0} {unit}, pen up {:.0} {unit} \
             ({:.0} {unit} before ordering)",
            drawn.strokes,
            drawn.contours,
            drawn.borders,
            drawn.creases,
            drawn.segments,
            length(drawn.pen_down_px),
            length(drawn.pen_up_px),
            length(drawn.pen_up_unordered_px)
        )
    }
}

impl Job<'_> {
    /// Writes the strokes of a picture to `path`.
    pub(super) fn lines(&mut self, path: &Path, pose: Pose) -> anyhow::Result<PictureReport> {
        let Some(SvgOptions(settings)) = &self.svg else { unreachable!("it was made for this output") };
        let still = PictureRequest::still(pose, self.args.size(), &self.style, self.world.light());
        let request = PictureRequest { clock: self.clock, ..still };
        let (gpu, frame, surfaces) = (&self.gpu, &mut self.frame, &mut self.world.surfaces);
        let (eyes, report) = render_strokes(gpu, frame, surfaces, &request, self.pair.as_ref())
            .with_context(|| format!("cannot write {}", named(path)))?;
        let report = self.whole(report)?;
        let (layers, drawn) = match (self.args.stereo.eyes(), eyes.as_slice()) {
            (Eyes::Anaglyph | Eyes::GreyAnaglyph, [left, right]) => {
                let (left, mut drawn) = vector::layer_of_eye(left, settings, LEFT_INK);
                let (right, of_right) = vector::layer_of_eye(right, settings, RIGHT_INK);
                drawn.append(&of_right);
                (vec![left, right], drawn)
            }
            (Eyes::Right, [_, right]) => vector::layers(right, settings),
            _ => vector::layers(eyes.first().map_or(&[], Vec::as_slice), settings),
        };
        let [width, height] = self.args.size();
        let drawing = Drawing {
            title: format!("hachure: {}", self.style.name),
            description: format!(
                "Strokes of the style {}, {width}x{height} px, camera {}. Curves are within {} px of the strokes. Pen \
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
        svg::write_svg_noted(path, &drawing, Some(&self.imprint_text()))?;
        self.drawn.append(&drawn);
        Ok(report)
    }
}
