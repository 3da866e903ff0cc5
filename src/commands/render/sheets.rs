//! `render --sheets`: also cuts a large picture into sheets of paper for a small printer.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::paper::MM_PER_INCH;
use super::vector::SvgOptions;
use super::{Job, RenderArgs};
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::svg::{Drawing, Layer, Stroke, write_svg};
use crate::file::unnamed;
use crate::picture::sheets::sheet_path;
use crate::vector::sheet::sides_mm;
use crate::vector::sheets::{Place, Sheets, Wish};

/// Overlap of neighbouring sheets without `--sheets-overlap`.
const OVERLAP_MM: f64 = 10.0;
/// Margin without `--sheets-margin`: what most printers cannot print on.
const MARGIN_MM: f64 = 6.0;

/// How a picture is cut into sheets.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct SheetArgs {
    /// Also cut a .png or .svg with --paper or --dpi into sheets of this paper size (as in --paper, in either
    /// orientation), with crop marks and at the same scale. Next to the output, NAME-B3.png is the sheet in the second
    /// row (B) and third column (3)
    #[arg(long, value_name = "PAPER")]
    pub sheets: Option<String>,
    /// Overlap of neighbouring --sheets for gluing, in millimetres [default: 10]
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 1000.0))]
    pub sheets_overlap: Option<f64>,
    /// Margin that the printer of --sheets leaves on each side of the paper, in millimetres [default: 6]
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 1000.0))]
    pub sheets_margin: Option<f64>,
}

/// Plans the sheets into which the picture is cut; returns `None` if it is not cut.
///
/// # Errors
/// Returns what is wrong with the options, in one line.
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
            Some((option, _)) => Err(Misuse(format!("{option}: requires --sheets, which is not given"))),
            None => Ok(None),
        };
    };
    let output = named(&args.output);
    if !matches!(kind, OutputKind::Picture(PictureFormat::Png | PictureFormat::Svg)) || args.show.is_some() {
        let misuse = format!("--sheets: can only cut a drawing in a .png or .svg, and the output is {output}");
        return Err(Misuse(misuse));
    }
    let wish = Wish {
        paper_mm: sides_mm("--sheets", paper).map_err(Misuse)?,
        overlap_mm: sheets_overlap.unwrap_or(OVERLAP_MM),
        margin_mm: sheets_margin.unwrap_or(MARGIN_MM),
    };
    let unmeasured = || Misuse(format!("--sheets: {output} has no size in millimetres; add --paper or --dpi"));
    let sheets = match svg {
        Some(svg) => Sheets::new(svg.size_mm().ok_or_else(unmeasured)?, 1.0, false, &wish),
        None => {
            let px_per_mm = args.dpi.ok_or_else(unmeasured)? / MM_PER_INCH;
            Sheets::new(size_px.map(f64::from), px_per_mm, true, &wish)
        }
    };
    sheets.map(Some).map_err(Misuse)
}

/// Returns the files of a plan.
pub(super) fn paths(args: &RenderArgs, sheets: Option<&Sheets>) -> Vec<PathBuf> {
    let paths = |sheets: &Sheets| sheets.places().map(|place| sheet_path(&args.output, place)).collect();
    sheets.map(paths).unwrap_or_default()
}

/// Returns the names of the sheets of a plan, such as `B3`, in the order of [`paths`].
pub(super) fn names(sheets: Option<&Sheets>) -> Vec<String> {
    sheets.map(|sheets| sheets.places().map(Place::name).collect()).unwrap_or_default()
}

/// Report on a picture that was cut into sheets, as JSON.
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

/// Returns the number and size of the sheets as a line of text.
pub(super) fn summary(args: &RenderArgs, sheets: &Sheets) -> String {
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
        "{} sheets of {width}x{height} mm, {first} to {last}: {rows} {} of {columns}, overlapping by {overlap} mm",
        columns * rows,
        if rows == 1 { "row" } else { "rows" }
    )
}

/// Warns of sheets of an earlier poster of this name, which had more of them.
pub(super) fn warn_of_older(args: &RenderArgs, sheets: &Sheets) {
    let older = older(&args.output, &names(Some(sheets)));
    let (first, belong) = match older.as_slice() {
        [] => return,
        [only] => (named(only), "belongs"),
        [first, others @ ..] => (format!("{} and {} more", named(first), others.len()), "belong"),
    };
    tracing::warn!("{first} {belong} to an earlier poster of this name, not to this one");
}

/// Returns the sheets next to a poster that hachure drew and whose names are not among `names`.
fn older(output: &Path, names: &[String]) -> Vec<PathBuf> {
    let part = |part: Option<&OsStr>| part.map(|part| part.to_string_lossy().into_owned()).unwrap_or_default();
    let (begin, end) = (part(output.file_stem()) + "-", format!(".{}", part(output.extension())));
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_older = |entry: std::fs::DirEntry| {
        let file = entry.file_name().to_string_lossy().into_owned();
        let name = file.strip_prefix(&begin)?.strip_suffix(&end)?;
        let path = output.with_file_name(&file);
        (!names.iter().any(|own| own == name) && unnamed::is_sheet(&path, name)).then_some(path)
    };
    let mut older: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().filter_map(is_older).collect();
    older.sort();
    older
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
            let imprint = unnamed::imprint_of_sheet(&self.imprint_text(), &place.name());
            write_svg(&sheet_path(&self.args.output, place), &sheet, Some(&imprint))?;
        }
        Ok(())
    }
}

/// Returns the crop marks and the name of a sheet.
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
        fills: Vec::new(),
        texts: Vec::new(),
        strokes: sheets.marks(place).into_iter().map(stroke).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::imprint::Notes;
    use crate::file::png::{PngPixels, PngWriter};

    #[test]
    fn older_sheets_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let sheet = |file: &str, name: &str| {
            let imprint = unnamed::imprint_of_sheet("version = 1\n", name);
            let notes = Notes { imprint: Some(&imprint), ..Notes::default() };
            let mut writer = PngWriter::create_noted(&at(file), 1, 1, PngPixels::Rgb8, &notes).unwrap();
            writer.write_rows(&[0; 3]).unwrap();
            writer.finish().unwrap();
        };
        // A sheet of another name, one of another poster, and a file of the user.
        for (file, name) in [("w-A1.png", "A1"), ("w-B1.png", "B1"), ("w-B2.png", "A1"), ("v-B2.png", "B2")] {
            sheet(file, name);
        }
        crate::file::atomic::write(&at("w-C1.png"), b"mine").unwrap();
        assert_eq!(older(&at("w.png"), &["A1".to_owned()]), [at("w-B1.png")]);
        assert!(older(&at("w.png"), &["A1".to_owned(), "B1".to_owned()]).is_empty());
    }
}
