//! The page of a vector drawing: its own pixels, or a sheet of paper.

use crate::file::message::quoted;
use crate::file::svg::Unit;

/// Names of paper sizes and their sides in millimetres, the longer first.
const PAPERS: [(&str, [f64; 2]); 10] = [
    ("a0", [1189.0, 841.0]),
    ("a1", [841.0, 594.0]),
    ("a2", [594.0, 420.0]),
    ("a3", [420.0, 297.0]),
    ("a4", [297.0, 210.0]),
    ("a5", [210.0, 148.0]),
    ("a6", [148.0, 105.0]),
    ("letter", [279.4, 215.9]),
    ("legal", [355.6, 215.9]),
    ("tabloid", [431.8, 279.4]),
];

/// Longest side of a sheet.
const LONGEST_MM: f64 = 100_000.0;

/// The mapping of a picture's pixels to a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sheet {
    /// Width and height of the page, in `unit`.
    pub size: [f64; 2],
    /// Unit of all lengths on the page.
    pub unit: Unit,
    /// Length of a pixel, in `unit`.
    pub units_per_px: f64,
    /// Position of the picture's upper left corner on the page, in `unit`.
    pub origin: [f64; 2],
}

impl Sheet {
    /// Returns a page of the size of the picture, in pixels.
    pub(crate) fn pixels(size_px: [u32; 2]) -> Self {
        Self { size: size_px.map(f64::from), unit: Unit::Px, units_per_px: 1.0, origin: [0.0; 2] }
    }

    /// Returns a page of the size of the picture, in millimetres.
    pub(crate) fn dots(size_px: [u32; 2], mm_per_px: f64) -> Self {
        let size = size_px.map(|side| f64::from(side) * mm_per_px);
        Self { size, unit: Unit::Mm, units_per_px: mm_per_px, origin: [0.0; 2] }
    }

    /// Returns a sheet of paper in the orientation of the picture, with the picture centred and as large as the margins
    /// allow. `paper` is `a0` to `a6`, `letter`, `legal`, `tabloid` or `WIDTHxHEIGHT` in millimetres.
    ///
    /// # Errors
    /// One line about the wrong option, `--paper` or `--margin`.
    pub(crate) fn paper(paper: &str, margin_mm: f64, size_px: [u32; 2]) -> Result<Self, String> {
        let [longer, shorter] = sides_mm("--paper", paper)?;
        let size = if size_px[0] >= size_px[1] { [longer, shorter] } else { [shorter, longer] };
        if !(margin_mm >= 0.0 && margin_mm.is_finite()) {
            return Err(format!("--margin {margin_mm}: it must be a number of millimetres, 0 or more"));
        }
        let inner = size.map(|side| side - 2.0 * margin_mm);
        if inner[0].min(inner[1]) < 1.0 {
            let cause = "leaves less than 1 mm of the paper";
            return Err(format!("--margin {margin_mm}: {cause}, which is {}x{} mm", size[0], size[1]));
        }
        let picture = size_px.map(f64::from);
        let units_per_px = (inner[0] / picture[0]).min(inner[1] / picture[1]);
        let origin = [0, 1].map(|i| 0.5 * (size[i] - picture[i] * units_per_px));
        Ok(Self { size, unit: Unit::Mm, units_per_px, origin })
    }

    /// Returns the transformation from pixels of the picture to the page.
    pub(crate) fn place(&self) -> kurbo::Affine {
        kurbo::Affine::translate((self.origin[0], self.origin[1])) * kurbo::Affine::scale(self.units_per_px)
    }
}

/// Returns the sides of a paper size in millimetres, the longer first. Errors begin with `option`.
///
/// # Errors
/// An unknown name, or a size that is not `WIDTHxHEIGHT` in millimetres.
pub(crate) fn sides_mm(option: &str, paper: &str) -> Result<[f64; 2], String> {
    let name = paper.to_ascii_lowercase();
    let name = name.strip_suffix("mm").unwrap_or(&name);
    if let Some((_, sides)) = PAPERS.iter().find(|(known, _)| *known == name) {
        return Ok(*sides);
    }
    let side = |text: &str| text.parse::<f64>().ok().filter(|side| (1.0..=LONGEST_MM).contains(side));
    name.split_once('x').and_then(|(a, b)| Some([side(a)?, side(b)?])).map(|[a, b]| [a.max(b), a.min(b)]).ok_or_else(
        || {
            let known = PAPERS.map(|(name, _)| name).join(", ");
            format!("{option} {}: it must be {known}, or WIDTHxHEIGHT in millimetres like 300x200", quoted(paper))
        },
    )
}
