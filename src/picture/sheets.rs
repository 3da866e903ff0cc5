//! Writes a poster as PNG sheets for a small printer while it is drawn. In memory is only one row of pixels of each
//! open sheet.

pub use crate::vector::sheets::{Place, Sheets, Wish};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::file::FileError;
use crate::file::imprint::Notes;
use crate::file::png::{EndedPng, PngPixels, PngWriter};
use crate::file::unnamed::imprint_of_sheet;
use crate::lettering::ink::{PenStroke, cover};

/// Bytes per pixel of the poster.
const PIXEL: usize = 4;

/// Returns the path of a sheet: `NAME-B3.png` for the poster `NAME.png`.
pub fn sheet_path(poster: &Path, place: Place) -> PathBuf {
    let stem = poster.file_stem().unwrap_or_default().to_string_lossy();
    let ending = poster.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
    poster.with_file_name(format!("{stem}-{}{ending}", place.name()))
}

/// Sheets that are being written. No file appears under its final name before [`SheetWriter::end`] and
/// [`EndedSheets::commit`].
pub struct SheetWriter<'a> {
    sheets: Sheets,
    poster: PathBuf,
    notes: Notes<'a>,
    /// Next row of the poster.
    next_row: usize,
    open: Vec<OpenSheet>,
    /// Number of rows of sheets that were begun.
    begun: u32,
    ended: Vec<EndedPng>,
}

/// Complete sheets that do not have their final names yet.
pub struct EndedSheets(Vec<EndedPng>);

impl EndedSheets {
    /// Renames the files to their final names.
    ///
    /// # Errors
    /// A full disk, or a missing folder.
    pub fn commit(self) -> Result<(), FileError> {
        self.0.into_iter().try_for_each(EndedPng::commit)
    }
}

struct OpenSheet {
    png: PngWriter,
    marks: Vec<PenStroke>,
    /// First pixel of the poster in the window.
    begin: [usize; 2],
    end: [usize; 2],
    inset: usize,
    /// Width and height of the sheet in pixels.
    paper: [usize; 2],
}

impl<'a> SheetWriter<'a> {
    /// Creates the writer for a poster with the path `poster`; `notes` are the metadata of
    /// every sheet, whose imprint also has the name of the sheet.
    pub fn new(sheets: Sheets, poster: &Path, notes: Notes<'a>) -> Self {
        Self { sheets, poster: poster.to_owned(), notes, next_row: 0, open: Vec::new(), begun: 0, ended: Vec::new() }
    }

    /// Appends complete rows of the poster's RGBA pixels.
    ///
    /// # Errors
    /// A missing or read-only folder; a full disk.
    pub fn write_rows(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let row_bytes = self.sheets.poster[0] as usize * PIXEL;
        let rows = self.next_row..self.next_row + rgba.len() / row_bytes;
        // A band may be taller than a row of sheets. Apart from the overlap, a row ends before the next one begins.
        let mut first = rows.start;
        while first < rows.end {
            while self.begun < self.sheets.counts[1] && self.begin_of(self.begun) <= first {
                self.begin_row(self.begun)?;
                self.begun += 1;
            }
            let next = if self.begun < self.sheets.counts[1] { self.begin_of(self.begun) } else { usize::MAX };
            let until = self.open.iter().map(|sheet| sheet.end[1]).chain([next, rows.end]).min().unwrap_or(rows.end);
            let part = &rgba[(first - rows.start) * row_bytes..(until - rows.start) * row_bytes];
            self.open.par_iter_mut().try_for_each(|sheet| sheet.write_rows(part, row_bytes))?;
            let (ended, open) = std::mem::take(&mut self.open).into_iter().partition(|sheet| sheet.end[1] <= until);
            self.open = open;
            for sheet in ended {
                self.ended.push(sheet.end()?);
            }
            first = until;
        }
        self.next_row = rows.end;
        Ok(())
    }

    /// Finishes the sheets, which must have all rows.
    ///
    /// # Errors
    /// Rows are missing; a full disk.
    pub fn end(mut self) -> Result<EndedSheets, FileError> {
        // A sheet that is still open is incomplete and reports this as an error.
        for sheet in std::mem::take(&mut self.open) {
            self.ended.push(sheet.end()?);
        }
        Ok(EndedSheets(self.ended))
    }

    fn begin_of(&self, row: u32) -> usize {
        self.sheets.part(Place { column: 0, row })[0][1] as usize
    }

    fn begin_row(&mut self, row: u32) -> Result<(), FileError> {
        for column in 0..self.sheets.counts[0] {
            let place = Place { column, row };
            let [width, height] = self.sheets.paper.map(|side| side as u32);
            let path = sheet_path(&self.poster, place);
            let imprint = self.notes.imprint.map(|poster| imprint_of_sheet(poster, &place.name()));
            let notes = Notes { imprint: imprint.as_deref(), ..self.notes };
            let png = PngWriter::create_noted(&path, width, height, PngPixels::Rgb8, &notes)?;
            let width_px = self.sheets.pen();
            let marks = self.sheets.marks(place).into_iter().map(|points| PenStroke { points, width_px }).collect();
            let [begin, end] = self.sheets.part(place).map(|corner| corner.map(|at| at as usize));
            let inset = self.sheets.inset as usize;
            let mut sheet = OpenSheet { png, marks, begin, end, inset, paper: [width as usize, height as usize] };
            sheet.write_bare(0..inset)?;
            self.open.push(sheet);
        }
        Ok(())
    }
}

impl OpenSheet {
    /// Returns a row of the sheet with marks, without the poster.
    fn bare(&self, row: usize) -> Vec<u8> {
        let mut covered = vec![0.0; self.paper[0]];
        cover(&self.marks, 0.0, row as f64, &mut covered);
        covered.iter().flat_map(|part| [255 - (part * 255.0).round() as u8; 3]).collect()
    }

    fn write_bare(&mut self, rows: std::ops::Range<usize>) -> Result<(), FileError> {
        for row in rows {
            let bytes = self.bare(row);
            self.png.write_rows(&bytes)?;
        }
        Ok(())
    }

    /// Appends rows of the poster that are all inside the window.
    fn write_rows(&mut self, rgba: &[u8], row_bytes: usize) -> Result<(), FileError> {
        let first = self.inset + self.end[1] - self.begin[1] - self.rows_left();
        for (i, row) in rgba.chunks_exact(row_bytes).enumerate() {
            let mut bytes = self.bare(first + i);
            let shown = row[self.begin[0] * PIXEL..self.end[0] * PIXEL].chunks_exact(PIXEL);
            let pixels = bytes[3 * self.inset..].chunks_exact_mut(3);
            pixels.zip(shown).for_each(|(to, from)| to.copy_from_slice(&from[..3]));
            self.png.write_rows(&bytes)?;
        }
        Ok(())
    }

    /// Returns the number of rows of the window that are still missing.
    fn rows_left(&self) -> usize {
        let below = self.paper[1] - self.inset - (self.end[1] - self.begin[1]);
        self.png.rows_left().saturating_sub(below)
    }

    fn end(mut self) -> Result<EndedPng, FileError> {
        if self.rows_left() == 0 {
            let below = self.paper[1] - self.png.rows_left();
            self.write_bare(below..self.paper[1])?;
        }
        self.png.end()
    }
}
