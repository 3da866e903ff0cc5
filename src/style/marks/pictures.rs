//! The pictures of a stack of marks, looked at when a style is loaded. `tones/tonal_art_map/stack` makes a map of them.

use std::io::BufReader;
use std::path::Path;

use super::{Recipe, SIDES_PX};
use crate::file::input::open_regular;
use crate::file::one_line;
use crate::file::png::{Picture, read_rgba8};
use crate::style::StyleError;

/// That every picture of a recipe is there and can be decoded, is a square with a side that tiles may have, and is as
/// wide as the first.
///
/// # Errors
/// [`StyleError::MarkImage`] for the first that does not hold.
pub fn check(recipe: &Recipe) -> Result<(), StyleError> {
    read(recipe).map(|_| ())
}

/// The pictures of a recipe: squares with a side that tiles may have, all as wide as the first.
///
/// # Errors
/// [`StyleError::MarkImage`] when one is not there, cannot be decoded, or is of another size.
pub fn read(recipe: &Recipe) -> Result<Vec<Picture>, StyleError> {
    let mut pictures: Vec<Picture> = Vec::with_capacity(recipe.images.len());
    for path in &recipe.images {
        let wrong = |cause| StyleError::MarkImage { path: path.display().to_string(), cause };
        let picture = picture(path).map_err(wrong)?;
        if let Some(first) = pictures.first().filter(|first| first.width != picture.width) {
            let cause = format!("it is {} px wide, but the first picture is {}", picture.width, first.width);
            return Err(wrong(cause));
        }
        pictures.push(picture);
    }
    Ok(pictures)
}

/// A picture that holds, or what is wrong with it.
fn picture(path: &Path) -> Result<Picture, String> {
    let unread = |words: &str| format!("cannot read the picture: {}", one_line(words));
    // The words of an error that names the file end with those of its cause, and the file is named already.
    let told = |error: &dyn std::error::Error| error.source().map_or_else(|| error.to_string(), ToString::to_string);
    // The header comes first: a damaged one may claim a size that no memory holds.
    let file = open_regular(path).map_err(|error| format!("cannot read the picture: {error}"))?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    let header = decoder.read_header_info().map_err(|error| unread(&told(&error)))?;
    let [width, height] = [header.width, header.height];
    let [least, most] = SIDES_PX;
    if width != height || !width.is_power_of_two() || !(least..=most).contains(&width) {
        return Err(format!(
            "it is {width} × {height} px; pictures of marks are squares with a side that is a power of two from \
             {least} to {most}"
        ));
    }
    let picture = read_rgba8(path).map_err(|error| unread(&told(&error)))?;
    if picture.rgba.len() != 4 * width as usize * height as usize {
        return Err(unread("it has another size than its header says"));
    }
    Ok(picture)
}
