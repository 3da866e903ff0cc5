//! Makes pictures small enough for a repository.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, ensure};
use hachure::file::atomic::AtomicFile;

/// A larger picture is an error.
const MAX_BYTES: u64 = 400_000;

/// Fewer bits per channel would show as bands.
const MIN_BITS: u32 = 6;

/// Rewrites a picture without its alpha channel, and with a palette if rounding to some number of bits leaves at most
/// 256 colours.
pub(crate) fn shrink(path: &Path) -> anyhow::Result<()> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().context("the picture is too large")?];
    let info = reader.next_frame(&mut bytes)?;
    ensure!(
        info.color_type == png::ColorType::Rgba && info.bit_depth == png::BitDepth::Eight,
        "the picture is not 8-bit RGBA"
    );
    let pixels: Vec<[u8; 3]> = bytes.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let rounded =
        (MIN_BITS..=8).rev().map(|bits| pixels.iter().map(|pixel| pixel.map(|value| rounded(value, bits))).collect());
    let palette_of = |pixels: &Vec<[u8; 3]>| {
        let mut palette: BTreeMap<[u8; 3], u8> = pixels.iter().map(|pixel| (*pixel, 0)).collect();
        let is_small = palette.len() <= 256;
        (0..=255).zip(palette.values_mut()).for_each(|(number, entry)| *entry = number);
        is_small.then_some(palette)
    };
    let found = rounded.into_iter().find_map(|pixels: Vec<[u8; 3]>| Some((palette_of(&pixels)?, pixels)));

    let mut file = AtomicFile::create(path)?;
    let mut encoder = png::Encoder::new(file.writer(), info.width, info.height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let bytes = if let Some((palette, pixels)) = found {
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.keys().flatten().copied().collect::<Vec<u8>>());
        pixels.iter().map(|pixel| palette[pixel]).collect()
    } else {
        encoder.set_color(png::ColorType::Rgb);
        pixels.concat()
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    file.commit()?;
    let bytes = std::fs::metadata(path)?.len();
    ensure!(bytes <= MAX_BYTES, "{bytes} bytes are more than a picture may have");
    Ok(())
}

/// Rounds to `bits` bits; black and white stay as they are.
fn rounded(value: u8, bits: u32) -> u8 {
    let most = (1_u32 << bits) - 1;
    let step = (u32::from(value) * most + 127) / 255;
    ((step * 255 + most / 2) / most) as u8
}
