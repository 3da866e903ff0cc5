//! Screenshots: write the picture, without the panel, to a file in the current folder.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::file::FileError;
use crate::file::png::PngWriter;
use crate::frame::Renderer;
use crate::gpu::Gpu;
use crate::picture::{self, PictureError, PictureRequest, eyes};
use crate::scene::stereo::Eyes;
use crate::window::settings::Settings;
use crate::world::Surfaces;

/// Renders `request` and writes it to `folder`, under a name that does not exist yet.
///
/// # Errors
/// Fails if the GPU or writing the file fails.
pub(super) fn take(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    settings: &Settings,
    folder: &Path,
) -> Result<PathBuf, PictureError<FileError>> {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = free_path(folder, &stem(now));
    let [width, height] = request.size_px;
    let width = if settings.eyes == Eyes::SideBySide { 2 * width } else { width };
    let mut writer = PngWriter::create(&path, width, height).map_err(PictureError::Sink)?;
    if settings.eyes == Eyes::Mono {
        picture::render(gpu, renderer, world, request, |band| writer.write_rows(&picture::srgb8(&band.picture)))?;
    } else {
        picture::render_pair(gpu, renderer, world, request, &settings.pair, |bands| {
            writer.write_rows(&picture::srgb8(&eyes::joined(width, eyes::shown(settings.eyes, bands))))
        })?;
    }
    writer.finish().map_err(PictureError::Sink)?;
    Ok(path)
}

/// Returns the path `stem.png`, or with a number if that exists already.
fn free_path(folder: &Path, stem: &str) -> PathBuf {
    let numbered = (2..).map(|number| format!("{stem}-{number}.png"));
    let mut paths = std::iter::once(format!("{stem}.png")).chain(numbered).map(|name| folder.join(name));
    paths.find(|path| path.symlink_metadata().is_err()).unwrap_or_else(|| folder.join(stem))
}

/// Returns `hachure-YYYYMMDD-HHMMSS` in UTC: the standard library has no other time zones.
fn stem(since_1970: Duration) -> String {
    let seconds = since_1970.as_secs();
    let [year, month, day] = date(seconds / 86_400);
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("hachure-{year:04}{month:02}{day:02}-{hour:02}{minute:02}{second:02}")
}

/// Returns year, month and day of the Gregorian calendar.
fn date(days_since_1970: u64) -> [u64; 3] {
    // Skip whole cycles of 400 years, which all have the same number of days; then advance year by year.
    let (mut year, mut day) = (1970 + days_since_1970 / 146_097 * 400, days_since_1970 % 146_097);
    let leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    while day >= 365 + u64::from(leap(year)) {
        day -= 365 + u64::from(leap(year));
        year += 1;
    }
    let mut month = 1;
    for mut length in [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        length += u64::from(month == 2 && leap(year));
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    [year, month, day + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_contain_the_time() {
        assert_eq!(stem(Duration::ZERO), "hachure-19700101-000000");
        assert_eq!(stem(Duration::from_secs(951_782_399)), "hachure-20000228-235959");
        assert_eq!(stem(Duration::from_secs(951_868_799)), "hachure-20000229-235959");
        assert_eq!(stem(Duration::from_secs(1_735_689_599)), "hachure-20241231-235959");
        assert_eq!(stem(Duration::from_secs(1_772_323_200)), "hachure-20260301-000000");
    }

    #[test]
    fn a_taken_name_is_not_taken_again() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(free_path(folder.path(), "a"), folder.path().join("a.png"));
        for name in ["a.png", "a-2.png"] {
            std::fs::File::create_new(folder.path().join(name)).unwrap();
        }
        assert_eq!(free_path(folder.path(), "a"), folder.path().join("a-3.png"));
    }
}
