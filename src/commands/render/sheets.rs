//! `render --sheets`: a large picture is also cut into sheets for a small printer, beside it.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::paper::MM_PER_INCH;
use super::vector::SvgOptions;
use super::{Job, RenderArgs};
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::svg::{Drawing, Layer, Stroke, write_svg_noted};
use crate::picture::sheets::sheet_path;
use crate::vector::sheet::sides_mm;
use crate::vector::sheets::{Place, Sheets, Wish};

/// Of neighbours, unless somebody says otherwise.
const OVERLAP_MM: f64 = 10.0;
/// What most printers leave free, unless somebody says otherwise.
const MARGIN_MM: f64 = 6.0;

/// How a picture is cut into sheets.
#[derive(Clone, Debug, Default, Args)]
pub struct SheetArgs {
    /// Also cut a .png or .svg with --paper or --dpi into sheets of this paper, as --paper names it, upright or lying:
    /// NAME-A1.png, NAME-A2.png and so on beside it, at its scale, with crop marks
    #[arg(long, value_name = "PAPER")]
    pub sheets: Option<String>,
    /// How far neighbours of --sheets overlap, to be glued, in millimetres [default: 10]
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 1000.0))]
    pub sheets_overlap: Option<f64>,
    /// What the printer of --sheets leaves free at each side of the paper, in millimetres [default: 6]
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 1000.0))]
    pub sheets_margin: Option<f64>,
}

/// How the picture is cut; none if it is not.
///
/// # Errors
/// What is wrong with the options, in one line.
pub(super) fn plan(
    args: &RenderArgs,
    kind: &OutputKind,
    size_px: [u32; 2],
    svg: Option<&SvgOptions>,
) -> Result<Option<Sheets>, Misuse> {
    let SheetArgs { sheets, sheets_overlap, sheets_margin } = &args.sheets;
    let Some(paper) = sheets else {
        let given = [("--sheets-overlap", sheets_overlap.is_some()), ("--sheets-margin", sheets_margin.is_some())];
        return match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) => Err(Misuse(format!("{option}: it is for --sheets, which is not given"))),
            None => Ok(None),
        };
    };
    let output = named(&args.output);
    if !matches!(kind, OutputKind::Picture(PictureFormat::Png | PictureFormat::Svg)) || args.show.is_some() {
        let misuse = format!("--sheets: it cuts a drawing in a .png or an .svg, and the output is {output}");
        return Err(Misuse(misuse));
    }
    let wish = Wish {
        paper_mm: sides_mm("--sheets", paper).map_err(Misuse)?,
        overlap_mm: sheets_overlap.unwrap_or(OVERLAP_MM),
        margin_mm: sheets_margin.unwrap_or(MARGIN_MM),
    };
    let unmeasured = || Misuse(format!("--sheets: {output} has no size in millimetres; --paper or --dpi gives it one"));
    let sheets = match svg {
        Some(svg) => Sheets::new(svg.size_mm().ok_or_else(unmeasured)?, 1.0, false, &wish),
        None => {
            let px_per_mm = args.dpi.ok_or_else(unmeasured)? / MM_PER_INCH;
            Sheets::new(size_px.map(f64::from), px_per_mm, true, &wish)
        }
    };
    sheets.map(Some).map_err(Misuse)
}

/// The files of a plan.
pub(super) fn paths(args: &RenderArgs, sheets: Option<&Sheets>) -> Vec<PathBuf> {
    let paths = |sheets: &Sheets| sheets.places().map(|place| sheet_path(&args.output, place)).collect();
    sheets.map(paths).unwrap_or_default()
}

/// Of a picture that was cut, for programs.
#[derive(Serialize)]
pub(super) struct SheetsReport {
    files: Vec<PathBuf>,
    columns: u32,
    rows: u32,
    paper_mm: [f64; 2],
}

impl SheetsReport {
    pub(super) fn new(args: &RenderArgs, sheets: &Sheets) -> Self {
        let [columns, rows] = sheets.counts;
        Self { files: paths(args, Some(sheets)), columns, rows, paper_mm: sheets.paper_mm }
    }
}

/// How many sheets there are and how large they are, in a line.
pub(super) fn told(args: &RenderArgs, sheets: &Sheets) -> String {
    let [columns, rows] = sheets.counts;
    let [width, height] = sheets.paper_mm;
    let name = |place: Place| named(sheet_path(&args.output, place));
    let first = name(Place { column: 0, row: 0 });
    if columns * rows == 1 {
        return format!("1 sheet of {width}x{height} mm: {first}");
    }
    let last = name(Place { column: columns - 1, row: rows - 1 });
    let overlap = args.sheets.sheets_overlap.unwrap_or(OVERLAP_MM);
    format!(
        "{} sheets of {width}x{height} mm, {first} to {last}: {rows} {} of {columns}, which overlap by {overlap} mm",
        columns * rows,
        if rows == 1 { "row" } else { "rows" }
    )
}

impl Job<'_> {
    /// Writes the sheets of a drawing.
    pub(super) fn svg_sheets(&self, drawing: &Drawing) -> anyhow::Result<()> {
        let Some(sheets) = &self.sheets else { return Ok(()) };
        for place in sheets.places() {
            let mut layers = sheets.layers(&drawing.layers, place);
            layers.push(marks(sheets, place));
            let sheet = Drawing {
                title: format!("{}, sheet {}", drawing.title, place.name()),
                size: sheets.paper,
                layers,
                ..drawing.clone()
            };
            write_svg_noted(&sheet_path(&self.args.output, place), &sheet, Some(&self.imprint_text()))?;
        }
        Ok(())
    }
}

/// Crop marks and the name of a sheet.
fn marks(sheets: &Sheets, place: Place) -> Layer {
    let stroke = |points: Vec<glam::DVec2>| {
        let mut path = kurbo::BezPath::new();
        for (i, point) in points.iter().enumerate() {
            let to = (point.x, point.y);
            if i == 0 { path.move_to(to) } else { path.line_to(to) }
        }
        Stroke { path, width: sheets.pen(), opacity: 1.0, ink: None }
    };
    Layer {
        id: "sheet-marks".to_owned(),
        label: format!("Crop marks of sheet {}", place.name()),
        ink: Some("#000000".to_owned()),
        kind: "mark",
        pen: None,
        strokes: sheets.marks(place).into_iter().map(stroke).collect(),
    }
}
