//! The files that an export would replace although hachure did not draw them.

use std::path::{Path, PathBuf};

use super::{Export, Kind, Page};
use crate::file::pattern::{FramePattern, OutputKind};
use crate::file::unnamed;
use crate::picture::sheets::sheet_path;

/// Largest number of frames that are looked at.
const MOST_FRAMES: usize = 1000;

impl Export {
    /// Returns the files under the names of this export that hachure did not draw: of the output, of numbered frames, of
    /// the sheets of a poster, and of the sidecar files of a map. Frames that the film does not reach are among them.
    pub(crate) fn foreign(&self) -> Vec<PathBuf> {
        let output = PathBuf::from(self.output_path());
        let mut found = Vec::new();
        if let Ok(OutputKind::Frames(pattern, _)) = OutputKind::of(&output) {
            found.extend(frames(&pattern).into_iter().filter(|path| !unnamed::is_export(path)));
        } else if is_there(&output) && !unnamed::is_export(&output) {
            found.push(output.clone());
        }
        match self.kind {
            Kind::Sheets => {
                let sheets = Page::of(self).ok().and_then(|page| page.sheets);
                let places = sheets.into_iter().flat_map(|sheets| sheets.places().collect::<Vec<_>>());
                let files = places.map(|place| (sheet_path(&output, place), place.name()));
                found.extend(
                    files.filter(|(path, name)| is_there(path) && !unnamed::is_sheet(path, name)).map(|it| it.0),
                );
            }
            Kind::Map if self.ending() == "png" => {
                let files = [unnamed::world_file_path(&output), unnamed::aux_path(&output)];
                let own = unnamed::own_beside(&output, files.clone());
                found.extend(files.into_iter().filter(|path| is_there(path) && !own.contains(path)));
            }
            _ => {}
        }
        found
    }
}

/// Returns the frames that exist, in their order.
fn frames(pattern: &FramePattern) -> Vec<PathBuf> {
    let mut numbers = pattern.existing();
    numbers.sort_unstable();
    numbers.dedup();
    numbers.truncate(MOST_FRAMES);
    // A file may have other zeros in its name than the pattern gives it.
    numbers.into_iter().map(|number| pattern.path(number)).filter(|path| is_there(path)).collect()
}

fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;
    use crate::file::imprint::Notes;
    use crate::file::png::{PngPixels, PngWriter};

    fn draw(path: &Path, imprint: &str) {
        let notes = Notes { imprint: Some(imprint), ..Notes::default() };
        let mut writer = PngWriter::create_noted(path, 1, 1, PngPixels::Rgb8, &notes).unwrap();
        writer.write_rows(&[0; 3]).unwrap();
        writer.finish().unwrap();
    }

    #[test]
    fn files_of_others_are_found_under_all_names_of_an_export() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let names = |export: &Export| -> Vec<String> {
            let name = |path: PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
            export.foreign().into_iter().map(name).collect()
        };
        let mut export = Export { output: at("a.png").display().to_string(), ..Export::new([64, 36], 1) };
        assert!(names(&export).is_empty(), "nothing is there");
        draw(&at("a.png"), "version = 1\n");
        assert!(names(&export).is_empty(), "it is hachure's own");
        // The sheets of a poster: one is hachure's own, one has the name of another sheet, one is a text.
        export.set_kind(Kind::Sheets);
        export.paper = "a3".to_owned();
        draw(&at("a-A1.png"), &unnamed::imprint_of_sheet("version = 1\n", "A1"));
        draw(&at("a-A2.png"), &unnamed::imprint_of_sheet("version = 1\n", "A1"));
        atomic::write(&at("a-B1.png"), b"mine").unwrap();
        atomic::write(&at("a-Z9.png"), b"no sheet of this poster").unwrap();
        assert_eq!(names(&export), ["a-A2.png", "a-B1.png"]);
        // The world file of a map; the picture has no record of it.
        export.set_kind(Kind::Map);
        export.set_ending("png");
        atomic::write(&at("a.pgw"), b"mine").unwrap();
        assert_eq!(names(&export), ["a.pgw"]);
        export.set_ending("tif");
        assert!(names(&export).is_empty(), "a GeoTIFF has no sidecar files");
        atomic::write(&at("a.tif"), b"mine").unwrap();
        assert_eq!(names(&export), ["a.tif"]);
        // Numbered frames.
        export.set_kind(Kind::Film);
        export.output = at("f%02d.png").display().to_string();
        draw(&at("f00.png"), "version = 1\n");
        atomic::write(&at("f01.png"), b"mine").unwrap();
        atomic::write(&at("f1.png"), b"another name").unwrap();
        assert_eq!(names(&export), ["f01.png"]);
    }
}
