//! Screenshots: draw the picture, without the panel, into a file in the current folder, with its imprint.
//!
//! A screenshot is drawn as `hachure render` draws: by a renderer and a terrain of its own, which wait for all tiles. So
//! `render --like` draws the same picture again, and the window's frames go on. Why: `docs/decisions/screenshots.md`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use crate::file::imprint::Notes;
use crate::file::png::{PngPixels, PngWriter};
use crate::frame::Antialias;
use crate::gpu::Gpu;
use crate::imagery::ResidentImagery;
use crate::picture::imprint::Imprint;
use crate::picture::{self, PictureRequest, eyes};
use crate::pyramid::TileStore;
use crate::scene::Scene;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::view::Clock;
use crate::source::Silent;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::world::OpenWorld;

/// A picture to be taken: everything that it depends on, at the moment at which it was requested.
pub(super) struct Shot {
    /// The device of the window.
    pub gpu: Gpu,
    /// The scene with the light of the window.
    pub scene: Scene,
    /// The tiles of the scene, exaggerated.
    pub store: Arc<dyn TileStore>,
    /// The options of the window's terrain.
    pub options: TerrainOptions,
    /// How the picture is drawn: camera, style, size of one eye's picture and the rest.
    pub imprint: Imprint,
    /// Eyes that are shown.
    pub eyes: Eyes,
    /// The stereo pair.
    pub pair: Pair,
}

/// Draws a picture and writes it to `folder`, under a name that does not exist yet.
///
/// # Errors
/// Fails if tiles cannot be read, or if the GPU or writing the file fails. The message is one line.
pub(super) fn take(shot: &Shot, folder: &Path) -> Result<PathBuf, String> {
    let Shot { gpu, scene, store, options, imprint, eyes, pair } = shot;
    let options = TerrainOptions { loading: Loading::Wait, ..*options };
    let world = OpenWorld::on_gpu_with(gpu, scene.clone(), Arc::clone(store), options, &Silent);
    let mut world = world.map_err(|error| error.to_string())?;
    let pose = world.pose(&imprint.camera);
    let request = PictureRequest {
        pose,
        previous: pose,
        clock: Clock::still(imprint.more.time_s.unwrap_or(0.0)),
        size_px: imprint.size_px,
        style: &imprint.style,
        light: world.light(),
        planes: &[],
        samples: imprint.more.samples.unwrap_or(1),
        antialias: Antialias::None,
        tone_curve: imprint.more.tone_curve.as_deref().and_then(|curve| curve.parse().ok()),
        line_gaps: &[],
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let path = free_path(folder, &stem(now));
    let [width, height] = imprint.size_px;
    let width = if *eyes == Eyes::SideBySide { 2 * width } else { width };
    let text = imprint.text();
    let notes = Notes { imprint: Some(&text), ..Notes::default() };
    let mut writer =
        PngWriter::create_noted(&path, width, height, PngPixels::Rgba8, &notes).map_err(|it| it.to_string())?;
    let mut take = |bands| writer.write_rows(&picture::srgb8(&eyes::joined(width, bands)));
    let (renderer, surfaces) = (&mut None, &mut world.surfaces);
    let drawn = if *eyes == Eyes::Mono {
        picture::render(gpu, renderer, surfaces, &request, |band| take(vec![band]))
    } else {
        picture::render_pair(gpu, renderer, surfaces, &request, pair, |bands| take(eyes::shown(*eyes, bands)))
    };
    let report = drawn.map_err(|error| error.to_string())?;
    // A picture with missing tiles must not be written.
    if let Some(failure) = world.surfaces.imagery().and_then(ResidentImagery::failure) {
        return Err(format!("an image on the land could not be read: {failure}"));
    }
    match (report.tiles_failed, world.surfaces.terrain.failure()) {
        (0, None) => {}
        (_, Some(failure)) => return Err(format!("a tile could not be read: {failure}")),
        (tiles, None) => return Err(format!("{tiles} tiles could not be read")),
    }
    writer.finish().map_err(|error| error.to_string())?;
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
