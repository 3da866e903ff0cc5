//! The images of a stack of hatching marks, checked when a style is loaded. `tones/tonal_art_map/stack` makes a tonal
//! art map of them.

use std::path::Path;

use super::{Recipe, SIDES_PX};
use crate::file::png::Picture;
use crate::style::{StyleError, images};

/// Checks that every image of a recipe exists and can be decoded, is square with an allowed side ([`SIDES_PX`]), and
/// has the size of the first.
///
/// # Errors
/// [`StyleError::Image`] for the first image that fails.
pub(crate) fn check(recipe: &Recipe) -> Result<(), StyleError> {
    read(recipe).map(|_| ())
}

/// Reads the images of a recipe: squares with an allowed side ([`SIDES_PX`]), all of the same size.
///
/// # Errors
/// [`StyleError::Image`] if an image is missing, cannot be decoded, or has another size.
pub(crate) fn read(recipe: &Recipe) -> Result<Vec<Picture>, StyleError> {
    let mut pictures: Vec<Picture> = Vec::with_capacity(recipe.images.len());
    for path in &recipe.images {
        let wrong = |cause| StyleError::Image { path: path.display().to_string(), cause };
        let picture = picture(path).map_err(wrong)?;
        if let Some(first) = pictures.first().filter(|first| first.width != picture.width) {
            let cause = format!("it is {} px wide, but the first picture is {} px wide", picture.width, first.width);
            return Err(wrong(cause));
        }
        pictures.push(picture);
    }
    Ok(pictures)
}

/// Reads one image and checks its size; the error is the cause in one line.
fn picture(path: &Path) -> Result<Picture, String> {
    images::read(path, "picture", |[width, height]| {
        let [least, most] = SIDES_PX;
        if width == height && width.is_power_of_two() && (least..=most).contains(&width) {
            return Ok(());
        }
        Err(format!(
            "it is {width} × {height} px; pictures of marks must be square, with a side that is a power of two from \
             {least} to {most}"
        ))
    })
}
