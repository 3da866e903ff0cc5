//! The sidecar's record of a tile. It has a fixed size, so its offset follows from the tile's number.
//!
//! ```text
//!    0  f32 f32   lowest and highest height of the tile and its descendants, metres; NaN if all is no-data
//!    8  f32       error of the tile, metres
//!   12  4 × f32   errors at its corners
//!   28  u8        no-data: 0 none, 1 some, 2 all; then three zero bytes
//!   32  u32       CRC-32 of the tile's bytes in the GeoTIFF; 0 = not known
//!   36  256 × u8  lowest height of each patch of its page, in 255ths of the tile's range
//!  292  256 × u8  highest
//!  548  256 × f16 mesh error of each patch, metres
//! 1060  64 bytes  no-data of each patch, two bits each, the first patch lowest; 3 = no such patch
//! 1124  u32       CRC-32 of the tile's number (u64) and of all bytes before
//! ```
//! All numbers are little-endian. Quantised values are rounded outward: a lowest height down, a highest height and an
//! error up (an error beyond the range of f16 becomes infinite), so that bounds remain bounds.

use half::f16;

use super::bytes::{Cursor, put_f32s};
use crate::pyramid::surface::statistics::{PAGE_PATCHES, PatchPage, PatchStatistics, TileStatistics, Voids};

pub(crate) const RECORD_BYTES: usize = PAGE_AT + PAGE_BYTES + 4;

/// Number of patches in a page.
const PATCHES: usize = (PAGE_PATCHES * PAGE_PATCHES) as usize;

/// Length of a page in bytes.
pub(crate) const PAGE_BYTES: usize = 2 * PATCHES + 2 * PATCHES + PATCHES / 4;

const PAGE_AT: usize = 36;

/// The code of a patch beyond the grid.
const NO_PATCH: u8 = 3;

/// A decoded record: the statistics of a tile and its patches.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    /// The tile's height range, errors and no-data.
    pub statistics: TileStatistics,
    /// Height range, mesh error and no-data of the 256 patches of the tile's page.
    pub patches: PatchPage,
    /// CRC-32 of the tile's bytes in the GeoTIFF, if it is known.
    pub checksum: Option<u32>,
}

/// Returns the CRC-32 of a tile's bytes, never 0.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes).max(1)
}

/// Returns the height at step `step` of 255 in a range; the ends are exact.
fn step_m(step: u8, [low_m, high_m]: [f32; 2]) -> f32 {
    match step {
        0 => low_m,
        255 => high_m,
        _ => (f64::from(low_m) + f64::from(step) / 255.0 * (f64::from(high_m) - f64::from(low_m))) as f32,
    }
}

/// Returns the largest step at or below `min_m`, and the smallest one at or above `max_m`, of a range that contains
/// both.
fn steps_around(min_m: f32, max_m: f32, range_m: [f32; 2]) -> (u8, u8) {
    let scale = 255.0 / (f64::from(range_m[1]) - f64::from(range_m[0]));
    // Casts saturate; an empty range gives NaN or infinity here, which the loops correct.
    let mut low = ((f64::from(min_m) - f64::from(range_m[0])) * scale).floor() as u8;
    while low > 0 && step_m(low, range_m) > min_m {
        low -= 1;
    }
    let mut high = ((f64::from(max_m) - f64::from(range_m[0])) * scale).ceil() as u8;
    while high < 255 && step_m(high, range_m) < max_m {
        high += 1;
    }
    (low, high)
}

/// Returns the smallest f16 that is not below `error_m`: infinity above the largest.
fn f16_up(error_m: f32) -> f16 {
    let near = f16::from_f32(error_m);
    // For non-negative numbers, the next bit pattern is the next number.
    if near.to_f32() < error_m { f16::from_bits(near.to_bits() + 1) } else { near }
}

/// Encodes a page: `patches` are its 256 patches, row by row, `None` beyond the grid; `range_m` is the height range of
/// the tile, which contains those of the patches.
pub(crate) fn page_bytes(patches: &[Option<PatchStatistics>], range_m: [f32; 2]) -> Vec<u8> {
    let mut bytes = vec![0; PAGE_BYTES];
    for (i, patch) in patches.iter().enumerate() {
        let code = patch.map_or(NO_PATCH, |patch| patch.voids.code());
        bytes[4 * PATCHES + i / 4] |= code << (i % 4 * 2);
        let Some(patch) = patch else { continue };
        if patch.voids != Voids::All {
            (bytes[i], bytes[PATCHES + i]) = steps_around(patch.min_m, patch.max_m, range_m);
        }
        let at = 2 * PATCHES + 2 * i;
        bytes[at..at + 2].copy_from_slice(&f16_up(patch.mesh_error_m).to_le_bytes());
    }
    bytes
}

/// Decodes a page that [`page_bytes`] encoded with the same `range_m`; returns `None` if its length is wrong.
pub(in crate::pyramid) fn parse_page(bytes: &[u8], range_m: [f32; 2]) -> Option<PatchPage> {
    let mut bytes = Cursor { bytes };
    let (lows, highs) = (bytes.take(PATCHES)?, bytes.take(PATCHES)?);
    let (errors, codes) = (bytes.take(2 * PATCHES)?, bytes.take(PATCHES / 4)?);
    let patch = |i: usize| {
        let Some(voids) = Voids::from_code(codes[i / 4] >> (i % 4 * 2) & 3) else { return PatchPage::NOTHING };
        let mesh_error_m = f16::from_le_bytes([errors[2 * i], errors[2 * i + 1]]).to_f32();
        if voids == Voids::All {
            return PatchStatistics { mesh_error_m, ..PatchPage::NOTHING };
        }
        let height_m = |step| step_m(step, range_m);
        PatchStatistics { min_m: height_m(lows[i]), max_m: height_m(highs[i]), mesh_error_m, voids }
    };
    Some(PatchPage::new((0..PATCHES).map(patch).collect()))
}

/// Encodes the record of the tile with this number.
pub(crate) fn record_bytes(number: u64, statistics: &TileStatistics, checksum: u32, page: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(RECORD_BYTES);
    put_f32s(&mut bytes, &[statistics.min_m, statistics.max_m, statistics.error_m]);
    put_f32s(&mut bytes, &statistics.corner_errors_m);
    bytes.extend([statistics.voids.code(), 0, 0, 0]);
    bytes.extend(checksum.to_le_bytes());
    bytes.extend(page);
    bytes.extend(record_checksum(number, &bytes).to_le_bytes());
    bytes
}

fn record_checksum(number: u64, bytes: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&number.to_le_bytes());
    hasher.update(bytes);
    hasher.finalize()
}

/// Decodes the record of the tile with this number; returns `None` if it is damaged.
pub(crate) fn parse_record(number: u64, bytes: &[u8]) -> Option<Record> {
    if bytes.len() != RECORD_BYTES {
        return None;
    }
    let (body, sum) = bytes.split_at(RECORD_BYTES - 4);
    if sum != record_checksum(number, body).to_le_bytes() {
        return None;
    }
    let mut body = Cursor { bytes: body };
    let (min_m, max_m, error_m) = (body.f32()?, body.f32()?, body.f32()?);
    let corner_errors_m = [body.f32()?, body.f32()?, body.f32()?, body.f32()?];
    let voids = body.voids()?;
    body.take(3)?;
    let checksum = Some(body.u32()?).filter(|&sum| sum != 0);
    let statistics = TileStatistics { min_m, max_m, error_m, corner_errors_m, voids };
    Some(Record { statistics, patches: parse_page(body.bytes, [min_m, max_m])?, checksum })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILE: TileStatistics = TileStatistics {
        min_m: -12.3,
        max_m: 4017.77,
        error_m: 3.0,
        corner_errors_m: [1.0, 2.0, 3.0, 4.0],
        voids: Voids::Some,
    };

    fn patch(i: usize) -> Option<PatchStatistics> {
        let low = -12.3 + (i as f32) * 7.77;
        let patch = PatchStatistics {
            min_m: low,
            max_m: (low + 0.01 * i as f32 * i as f32).min(4017.77),
            mesh_error_m: 1e-9 * (i as f32).exp2().min(1e15),
            voids: Voids::None,
        };
        match i % 9 {
            8 => None,
            7 => Some(PatchStatistics { min_m: f32::NAN, max_m: f32::NAN, voids: Voids::All, ..patch }),
            _ => Some(patch),
        }
    }

    #[test]
    fn bounds_stay_bounds() {
        let patches: Vec<_> = (0..PATCHES).map(patch).collect();
        let range_m = [TILE.min_m, TILE.max_m];
        let bytes = record_bytes(7, &TILE, 99, &page_bytes(&patches, range_m));
        let record = parse_record(7, &bytes).unwrap();
        assert_eq!((record.statistics, record.checksum), (TILE, Some(99)));
        let step = (TILE.max_m - TILE.min_m) / 255.0;
        for (kept, patch) in record.patches.patches().iter().zip(&patches) {
            let Some(patch) = patch else {
                assert_eq!(kept.voids, Voids::All);
                continue;
            };
            assert_eq!(kept.voids, patch.voids);
            assert!(kept.mesh_error_m >= patch.mesh_error_m);
            assert!(kept.mesh_error_m <= patch.mesh_error_m * 1.001 + 1e-7 || kept.mesh_error_m.is_infinite());
            if patch.voids == Voids::None {
                assert!(kept.min_m <= patch.min_m && kept.max_m >= patch.max_m, "{kept:?} {patch:?}");
                assert!(kept.min_m > patch.min_m - 1.01 * step && kept.max_m < patch.max_m + 1.01 * step);
            }
        }
        // With another tile's number, or with any damaged byte, parsing gives `None`.
        assert!(parse_record(8, &bytes).is_none());
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(parse_record(7, &damaged).is_none(), "damaged at {at}");
        }
    }

    #[test]
    fn a_flat_tile_has_flat_patches() {
        let flat = PatchStatistics { min_m: 5.0, max_m: 5.0, mesh_error_m: 0.0, voids: Voids::None };
        let tile = TileStatistics { min_m: 5.0, max_m: 5.0, ..TILE };
        let bytes = record_bytes(0, &tile, 1, &page_bytes(&vec![Some(flat); PATCHES], [5.0, 5.0]));
        assert!(parse_record(0, &bytes).unwrap().patches.patches().iter().all(|patch| *patch == flat));
    }
}
