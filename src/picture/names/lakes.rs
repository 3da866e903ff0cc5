//! Lakes of a map, which may have labels with the height of their water.

use glam::DVec2;

use super::{Site, SiteKind, label};
use crate::frame::Renderer;
use crate::gpu::readback::read_as;
use crate::gpu::{Gpu, GpuError};
use crate::picture::PictureRequest;
use crate::scene::map::Map;
use crate::scene::view::{Rig, View};
use crate::surface::water::WATER;
use crate::world::Surfaces;

/// Longest side of the picture on which lakes are looked for, in pixels.
const SEEN_PX: f64 = 1024.0;
/// Least area of a lake with a label, in squares of a pixel of the style.
const LEAST_AREA: f64 = 60.0;
/// Importance of a lake, in metres of a summit's prominence, for each metre of the side of a square with its area.
const WEIGHT: f64 = 0.05;
/// Water is level, and at the level of the sea, within this height in metres. Rivers, and lakes whose ground was surveyed, are
/// not level.
const LEVEL_M: f64 = 0.5;
/// Number of places of a lake at which its level is looked at.
const PROBES: usize = 16;
/// Least distance of a lake's middle from the border of the picture, in pixels of the style: the symbol is not cut.
const BORDER: f64 = 8.0;
/// The middle of a lake is as far from its shore as this part of the largest distance in it, or farther.
const INNERMOST: f64 = 0.9;

/// The map on which lakes are looked for.
pub(crate) struct Inputs<'a> {
    pub map: &'a Map,
    /// Factor on the heights of the drawn land.
    pub exaggeration: f64,
    /// Pixels per pixel of the style.
    pub px: f64,
}

/// A lake on a picture.
#[derive(Clone, Debug, PartialEq)]
struct Lake {
    /// Number of its pixels.
    area: usize,
    /// A pixel of it that is far from its shore.
    middle: [usize; 2],
    /// Some of its pixels that are not at the shore.
    probes: Vec<[usize; 2]>,
}

/// Finds the lakes of a map, the largest first, each with a place in its middle: on a small picture of the map, where water
/// is as a layer of water would draw it. The sea does not count, nor does water that is not level.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn lakes(
    gpu: &Gpu,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    inputs: &Inputs<'_>,
) -> Result<Vec<Site>, GpuError> {
    let longest = f64::from(request.size_px.into_iter().max().unwrap_or(1).max(1));
    let factor = (SEEN_PX / longest).min(1.0);
    let size_px = request.size_px.map(|side| ((f64::from(side) * factor).round() as u32).max(1));
    let style = request.style.clone().scaled(factor).to_find_water();
    let view = View { clock: request.clock, ..View::whole(request.pose, request.pose, size_px) };
    let mut renderer = Renderer::new(gpu)?;
    renderer.render_eyes(gpu, world, &Rig::mono(view), &style, &request.light)?;
    let Some(water) = renderer.target(&WATER) else { return Ok(Vec::new()) };
    let shore_m = read_as::<f32>(gpu, water, [0, 0], size_px)?;
    let least_area = (LEAST_AREA * (inputs.px * factor).powi(2)).ceil().max(4.0) as usize;
    let sea_level_m = world.sea_level_m();
    let place_m = |pixel: [usize; 2]| inputs.map.world_from_px((DVec2::from(pixel.map(|at| at as f64)) + 0.5) / factor);
    let site = |lake: Lake| {
        let world_m = place_m(lake.middle);
        let mut levels_m: Vec<f64> =
            lake.probes.iter().filter_map(|pixel| world.terrain.height_m(place_m(*pixel))).collect();
        levels_m.sort_unstable_by(f64::total_cmp);
        let drawn_m = *levels_m.get(levels_m.len() / 2)?;
        let near_m = LEVEL_M * inputs.exaggeration;
        // The ground of a sea that the scene names may be below it.
        let is_sea = sea_level_m.map_or(drawn_m.abs() < near_m, |sea_level_m| drawn_m < sea_level_m + near_m);
        let is_level = levels_m.first()? + near_m > drawn_m && levels_m.last()? - near_m < drawn_m;
        let side_m = (lake.area as f64).sqrt() * inputs.map.pixel_m / factor;
        (is_level && !is_sea).then(|| Site {
            world_m: world_m.extend(drawn_m),
            text: label(None, Some(drawn_m / inputs.exaggeration)),
            weight: (WEIGHT * side_m).max(1e-3),
            kind: SiteKind::Lake,
        })
    };
    let border = (BORDER * inputs.px * factor).ceil() as usize;
    let lakes = found(&shore_m, size_px.map(|side| side as usize), least_area, border);
    Ok(lakes.into_iter().filter_map(site).collect())
}

/// Returns the lakes of a picture with at least so many pixels, the largest first, whose middles are not within `border`
/// pixels of the border. `shore_m` is the distance from the shore at each pixel, and not above 0 on land; it may have an
/// upper limit.
fn found(shore_m: &[f32], [width, height]: [usize; 2], least_area: usize, border: usize) -> Vec<Lake> {
    let is_inside = |pixel: usize| {
        let [x, y] = [pixel % width, pixel / width];
        x >= border && y >= border && x + border < width && y + border < height
    };
    let mut is_known: Vec<bool> = shore_m.iter().map(|shore_m| *shore_m <= 0.0).collect();
    let mut lakes = Vec::new();
    let mut pixels: Vec<usize> = Vec::new();
    for first in 0..shore_m.len() {
        if std::mem::replace(&mut is_known[first], true) {
            continue;
        }
        pixels.clear();
        pixels.push(first);
        let mut next = 0;
        while let Some(pixel) = pixels.get(next).copied() {
            next += 1;
            let column = pixel % width;
            let around = [
                pixel.checked_sub(width),
                Some(pixel + width).filter(|below| *below < shore_m.len()),
                (column > 0).then(|| pixel - 1),
                (column + 1 < width).then_some(pixel + 1),
            ];
            for other in around.into_iter().flatten() {
                if !std::mem::replace(&mut is_known[other], true) {
                    pixels.push(other);
                }
            }
        }
        let area = pixels.len();
        if area >= least_area {
            pixels.retain(|pixel| is_inside(*pixel));
            let probes = probes(&pixels, shore_m, width);
            lakes.extend(middle(&pixels, shore_m, width).map(|middle| Lake { area, middle, probes }));
        }
    }
    lakes.sort_by_key(|lake| (std::cmp::Reverse(lake.area), lake.middle));
    lakes
}

/// Returns the pixel that is nearest to the mean of those which are farthest from the shore; `None` if there are no pixels.
fn middle(pixels: &[usize], shore_m: &[f32], width: usize) -> Option<[usize; 2]> {
    let farthest_m = pixels.iter().map(|pixel| shore_m[*pixel]).fold(0.0, f32::max);
    let is_inner = |pixel: &&usize| f64::from(shore_m[**pixel]) >= INNERMOST * f64::from(farthest_m);
    let place = |pixel: usize| DVec2::new((pixel % width) as f64, (pixel / width) as f64);
    let inner: Vec<usize> = pixels.iter().filter(is_inner).copied().collect();
    let mean = inner.iter().map(|pixel| place(*pixel)).sum::<DVec2>() / inner.len().max(1) as f64;
    let nearest = inner.iter().min_by(|a, b| {
        let [a, b] = [a, b].map(|pixel| place(**pixel).distance_squared(mean));
        a.total_cmp(&b)
    });
    nearest.map(|pixel| [pixel % width, pixel / width])
}

/// Returns pixels of a lake, evenly among those that are at least half as far from the shore as the farthest one.
fn probes(pixels: &[usize], shore_m: &[f32], width: usize) -> Vec<[usize; 2]> {
    let farthest_m = pixels.iter().map(|pixel| shore_m[*pixel]).fold(0.0, f32::max);
    let inner: Vec<usize> = pixels.iter().filter(|pixel| shore_m[**pixel] >= 0.5 * farthest_m).copied().collect();
    let every = inner.len().div_ceil(PROBES).max(1);
    inner.iter().step_by(every).map(|pixel| [pixel % width, pixel / width]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns distances from the shore, of a drawing with a letter for each lake and dots on land, up to a limit.
    fn shores(drawing: &[&str], limit: f32) -> (Vec<f32>, usize) {
        let width = drawing[0].len();
        let is_land = |at: [i32; 2]| {
            let row = usize::try_from(at[1]).ok().and_then(|row| drawing.get(row));
            row.and_then(|row| row.as_bytes().get(at[0] as usize)).is_none_or(|letter| *letter == b'.')
        };
        let distance = |pixel: usize| {
            let at = [(pixel % width) as i32, (pixel / width) as i32];
            let land = (-9..=9).flat_map(|y| (-9..=9).map(move |x| [x, y]));
            let away = land.filter(|[x, y]| is_land([at[0] + x, at[1] + y])).map(|[x, y]| (x as f32).hypot(y as f32));
            away.fold(f32::INFINITY, f32::min).min(limit)
        };
        ((0..width * drawing.len()).map(distance).collect(), width)
    }

    #[test]
    fn lakes_are_found_with_their_middles() {
        let drawing = [
            "..............",
            ".aaaaaaa...b..",
            ".aaaaaaa..bb..",
            ".aaaaaaa......",
            ".aaaaaaa.cccc.",
            ".aaaaaaa.c....",
            "..aa.....cccc.",
            "..............",
        ];
        for limit in [100.0, 2.0] {
            let (shore_m, width) = shores(&drawing, limit);
            let size = [width, drawing.len()];
            let lakes = found(&shore_m, size, 4, 1);
            let areas: Vec<usize> = lakes.iter().map(|lake| lake.area).collect();
            assert_eq!(areas, [37, 9]);
            assert_eq!(lakes[0].middle, [4, 3], "{limit}");
            // The mean of a lake with a bay may be on land; its middle is not.
            let [x, y] = lakes[1].middle;
            assert_eq!(drawing[y].as_bytes()[x], b'c');
            assert_eq!(found(&shore_m, size, 3, 1).len(), 3);
            // The middle is inside of a border, however wide, or there is none.
            let [x, y] = found(&shore_m, size, 10, 3)[0].middle;
            assert!((3..8).contains(&x) && (3..5).contains(&y), "{x}, {y}");
            assert_eq!(found(&shore_m, size, 10, 4).len(), 0);
            // Planted: water everywhere is one lake.
            assert_eq!(found(&vec![1.0; shore_m.len()], size, 4, 1).len(), 1);
        }
    }
}
