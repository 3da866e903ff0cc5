//! The page of an export: its size, where the picture is on it, and where it is cut.

use super::{Export, Kind};
use crate::scene::ranges;
use crate::vector::sheet::{Sheet, sides_mm};
use crate::vector::sheets::{Sheets, Wish};

const MM_PER_INCH: f64 = 25.4;
/// The margin that the printer of sheets leaves, as `render` assumes it.
const SHEETS_MARGIN_MM: f64 = 6.0;

/// A page. Its lengths are millimetres, or pixels if it is not on paper.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Page {
    /// Width and height.
    pub size: [f64; 2],
    /// The picture: left, top, width, height.
    pub picture: [f64; 4],
    /// The sheets of a poster, in pixels of the poster.
    pub sheets: Option<Sheets>,
    /// The parts of the picture that sheets show: left, top, width, height.
    pub cuts: Vec<[f64; 4]>,
    /// Its size in words.
    pub words: String,
}

impl Page {
    /// Returns the page of an export.
    ///
    /// # Errors
    /// One line about the wrong option.
    pub(crate) fn of(export: &Export) -> Result<Self, String> {
        Self::of_options(export).map_err(|error| in_dialog(&error))
    }

    fn of_options(export: &Export) -> Result<Self, String> {
        let whole = |size: [f64; 2], words: String| Self {
            size,
            picture: [0.0, 0.0, size[0], size[1]],
            sheets: None,
            cuts: Vec::new(),
            words,
        };
        if !export.has_paper() {
            let [width, height] = export.size_px;
            ranges::check_pixels([width, height]).map_err(|rule| format!("--size: {rule}"))?;
            let twice = if export.kind == Kind::Stereo && export.eyes == super::STEREO[0] { 2.0 } else { 1.0 };
            let size = [twice * f64::from(width), f64::from(height)];
            return Ok(whole(size, format!("{} × {height} px", size[0])));
        }
        if export.kind == Kind::Lines {
            let sheet = Sheet::paper(export.paper.trim(), export.margin_mm, export.size_px)?;
            let [width, height] = export.size_px.map(|side| f64::from(side) * sheet.units_per_px);
            let words = format!("{} × {} mm, lines on {width:.0} × {height:.0} mm", sheet.size[0], sheet.size[1]);
            let picture = [sheet.origin[0], sheet.origin[1], width, height];
            return Ok(Self { picture, ..whole(sheet.size, words) });
        }
        let [longer, shorter] = sides_mm("--paper", export.paper.trim())?;
        let size = if export.is_portrait { [shorter, longer] } else { [longer, shorter] };
        let px_per_mm = export.dpi / MM_PER_INCH;
        let size_px = size.map(|side| (side * px_per_mm).round());
        if size_px.iter().any(|side| !ranges::SIDE_PX.holds(*side)) {
            let [width, height] = size_px;
            return Err(format!("--paper: at {} dots per inch it has {width}x{height} pixels", export.dpi));
        }
        ranges::check_pixels(size_px.map(|side| side as u32))
            .map_err(|rule| format!("--paper: at {} dots per inch {rule}", export.dpi))?;
        let words = format!("{} × {} mm, {} × {} px", size[0], size[1], size_px[0], size_px[1]);
        let mut page = whole(size, words);
        if export.kind == Kind::Sheets {
            let wish = Wish {
                paper_mm: sides_mm("--sheets", export.sheets.trim())?,
                overlap_mm: export.overlap_mm,
                margin_mm: SHEETS_MARGIN_MM,
            };
            let sheets = Sheets::new(size_px, px_per_mm, true, &wish)?;
            page.cuts = cuts(&sheets).into_iter().map(|cut| cut.map(|length| length / px_per_mm)).collect();
            let [width, height] = sheets.paper_mm;
            let count = page.cuts.len();
            page.words += &format!("; {count} sheet{} of {width} × {height} mm", if count == 1 { "" } else { "s" });
            page.sheets = Some(sheets);
        }
        Ok(page)
    }
}

/// Returns an error about an option of the command line with the name that the option has in the dialog.
fn in_dialog(error: &str) -> String {
    const NAMES: [(&str, &str); 5] = [
        ("--sheets-overlap", "Overlap"),
        ("--sheets", "Sheets"),
        ("--paper", "Paper"),
        ("--margin", "Margin"),
        ("--size", "Pixels"),
    ];
    let renamed = NAMES.iter().find_map(|(option, name)| Some(format!("{name}{}", error.strip_prefix(option)?)));
    renamed.unwrap_or_else(|| error.to_owned())
}

/// Returns the windows of sheets on their poster, in its units.
fn cuts(sheets: &Sheets) -> Vec<[f64; 4]> {
    let step = sheets.window.map(|side| side - sheets.overlap);
    let cut = |place: crate::vector::sheets::Place| {
        let [left, top] = [f64::from(place.column) * step[0], f64::from(place.row) * step[1]];
        let [right, bottom] = [0, 1].map(|i| ([left, top][i] + sheets.window[i]).min(sheets.poster[i]));
        [left, top, right - left, bottom - top]
    };
    sheets.places().map(cut).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn pages_have_the_size_that_render_draws() {
        let mut export = Export { output: "a.png".to_owned(), ..Export::new([1280, 720], 1) };
        assert_eq!(Page::of(&export).unwrap().words, "1280 × 720 px");
        export.set_kind(Kind::Stereo);
        assert_eq!(Page::of(&export).unwrap().size, [2560.0, 720.0]);
        export.set_kind(Kind::Lines);
        export.is_on_paper = true;
        let page = Page::of(&export).unwrap();
        // The picture is as wide as the paper without its margins, and centred.
        assert_eq!(page.size, [420.0, 297.0]);
        assert!((page.picture[0] - 10.0).abs() < 1e-9 && (page.picture[2] - 400.0).abs() < 1e-9, "{page:?}");
        assert!((page.picture[1] - 36.0).abs() < 1e-9 && (page.picture[3] - 225.0).abs() < 1e-9, "{page:?}");
        export.margin_mm = 200.0;
        assert!(Page::of(&export).unwrap_err().starts_with("Margin 200"));
        export.set_kind(Kind::Picture);
        assert_eq!(Page::of(&export).unwrap().words, "420 × 297 mm, 4961 × 3508 px");
        export.is_portrait = true;
        assert_eq!(Page::of(&export).unwrap().size, [297.0, 420.0]);
        (export.paper, export.dpi) = ("a0".to_owned(), 1e6);
        assert!(Page::of(&export).unwrap_err().starts_with("Paper: at 1000000 dots per inch"));
    }

    #[test]
    fn sheets_cover_the_poster_and_overlap() {
        let mut export = Export { output: "a.png".to_owned(), ..Export::new([1280, 720], 1) };
        export.set_kind(Kind::Sheets);
        (export.paper, export.dpi) = ("a2".to_owned(), 100.0);
        let page = Page::of(&export).unwrap();
        assert!(page.cuts.len() >= 4 && page.words.ends_with("mm") && page.words.contains("sheets of"), "{page:?}");
        let right = page.cuts.iter().map(|cut| cut[0] + cut[2]).fold(0.0, f64::max);
        let bottom = page.cuts.iter().map(|cut| cut[1] + cut[3]).fold(0.0, f64::max);
        assert!((right - 594.0).abs() < 0.2 && (bottom - 420.0).abs() < 0.2, "{right} {bottom}");
        let [first, second] = [page.cuts[0], page.cuts[1]];
        assert!((first[0] + first[2] - second[0] - 10.0).abs() < 0.2, "an overlap of 10 mm: {first:?} {second:?}");
        export.sheets = "10x10".to_owned();
        assert!(Page::of(&export).unwrap_err().starts_with("Sheets"));
    }
}
