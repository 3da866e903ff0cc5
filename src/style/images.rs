//! Images that recipes name: pictures of marks and of a stroke.

use std::io::BufReader;
use std::path::Path;

use crate::file::input::open_regular;
use crate::file::one_line;
use crate::file::png::{Picture, read_rgba8};

/// Reads a PNG. `called` names its purpose in messages ("picture of a stroke"), and `check` refuses widths and heights in
/// pixels.
///
/// # Errors
/// The cause in one line, without the name of the file: the image is missing, cannot be decoded, or has a wrong size.
pub(super) fn read(
    path: &Path,
    called: &str,
    check: impl FnOnce([u32; 2]) -> Result<(), String>,
) -> Result<Picture, String> {
    let unread = |words: &str| format!("cannot read the {called}: {}", one_line(words));
    // The caller already names the file, so of an error that names it again only the cause is used.
    let cause = |error: &dyn std::error::Error| error.source().map_or_else(|| error.to_string(), ToString::to_string);
    // The header is checked first: a damaged one may claim a size that does not fit into memory.
    let file = open_regular(path).map_err(|error| unread(&error.to_string()))?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    let header = decoder.read_header_info().map_err(|error| unread(&cause(&error)))?;
    let [width, height] = [header.width, header.height];
    check([width, height])?;
    let picture = read_rgba8(path).map_err(|error| unread(&cause(&error)))?;
    if picture.rgba.len() != 4 * width as usize * height as usize {
        return Err(unread("its pixel data does not match the size in its header"));
    }
    Ok(picture)
}

/// Returns the darkness of each pixel, 0 to 1: one minus the luminance (Rec. 709), on white paper where the picture is
/// transparent.
pub(crate) fn darkness(picture: &Picture) -> impl Iterator<Item = f32> {
    picture.rgba.chunks_exact(4).map(|pixel| {
        let [r, g, b, a] = [pixel[0], pixel[1], pixel[2], pixel[3]].map(|byte| f32::from(byte) / 255.0);
        a * (1.0 - (0.2126 * r + 0.7152 * g + 0.0722 * b))
    })
}
