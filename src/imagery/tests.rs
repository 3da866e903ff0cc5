//! Tests which tiles views need, and how they are resampled, without a GPU.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "files go to temporary folders")]

use std::path::Path;

use glam::{DVec2, DVec3};

use super::choose::Sight;
use super::{BORDER, ImageTile, Imagery, TILE_STRIDE};
use crate::scene::ImageFile;
use crate::scene::camera::Camera;
use crate::scene::view::View;
use crate::source::WorldMapping;
use crate::source::georeference::Georeference;
use crate::tests::common::{pose_of, random};
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::grid_projection::GridProjection;

const SAMPLES: u32 = 401;
const SPACING_M: f64 = 20.0;

/// Writes a PNG of `size` pixels a side.
pub(crate) fn write_png(path: &Path, size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 4]) {
    let bytes: Vec<u8> = (0..size[0] * size[1]).flat_map(|at| pixel(at % size[0], at / size[0])).collect();
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), size[0], size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

fn imagery(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 4]) -> Imagery {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    write_png(&path, size, pixel);
    let place = Georeference::local(SAMPLES, SAMPLES, SPACING_M);
    Imagery::open(&[ImageFile { path }], &place, [SAMPLES; 2]).unwrap()
}

fn sight(camera: &str, size_px: [u32; 2]) -> (Sight, View) {
    let pose = pose_of(&camera.parse::<Camera>().unwrap());
    let view = View::whole(pose, pose, size_px);
    let sight = Sight {
        origin_m: pose.position_m,
        eyes: vec![(DVec3::ZERO, view.frustum())],
        focal_px: view.focal_px(),
        earth_curvature: EarthCurvature::default(),
        range_m: [0.0, 0.0],
        spacing_m: SPACING_M,
    };
    (sight, view)
}

#[test]
fn the_tiles_that_the_shader_wants_are_chosen() {
    let imagery = imagery([2048, 2048], |_, _| [255; 4]);
    // Eight texels per sample: 3208 texels, which need 2^4 tiles of 256.
    assert_eq!((imagery.texels_per_sample, imagery.top), (8.0, 4));
    let place = Georeference::local(SAMPLES, SAMPLES, SPACING_M);
    let projection = GridProjection::fit(&WorldMapping::new(&place, SAMPLES, SAMPLES).unwrap(), SAMPLES, SAMPLES);
    let missing = |chosen: &[ImageTile], sight: &Sight, view: &View| {
        let chosen: std::collections::BTreeSet<ImageTile> = chosen.iter().copied().collect();
        // A tile without the one above it cannot be found.
        assert!(chosen.iter().all(|tile| {
            let above = ImageTile { level: tile.level + 1, x: tile.x / 2, y: tile.y / 2 };
            tile.level == imagery.top || chosen.contains(&above)
        }));
        let mut missing = 0;
        for number in 0..20_000 {
            let at_m =
                DVec2::new(random(number, 1) - 0.5, random(number, 2) - 0.5) * SPACING_M * f64::from(SAMPLES - 1);
            let from_eye = at_m.extend(0.0) - sight.origin_m;
            let Some(px) = view.place_px(from_eye) else { continue };
            let is_seen =
                px.cmpge(DVec2::ZERO).all() && px.cmplt(DVec2::from_array(view.picture_px.map(f64::from))).all();
            if !is_seen {
                continue;
            }
            let pixel_m = from_eye.length() / sight.focal_px;
            let level = (pixel_m / (SPACING_M / imagery.texels_per_sample)).log2().clamp(0.0, f64::from(imagery.top));
            let level = level.floor() as u32;
            let side = imagery.texel_samples(level) * 256.0;
            let at = (projection.grid_from_world(at_m) + 0.5) / side;
            missing += usize::from(!chosen.contains(&ImageTile { level, x: at.x as u32, y: at.y as u32 }));
        }
        missing
    };
    for camera in ["0,0,3000,0,-90,40", "-1500,-3500,400,20,-12,60", "100,50,60,0,-25,50"] {
        let (sight, view) = sight(camera, [320, 200]);
        let chosen = imagery.choose(&sight, &projection, 1024);
        assert!(chosen.bias == 0.0 && chosen.tiles.len() < 120, "{camera}: {} tiles", chosen.tiles.len());
        assert_eq!(missing(&chosen.tiles, &sight, &view), 0, "{camera}");
        // Planted: a view that is coarser by a level lacks tiles.
        let coarser = imagery.choose(&Sight { focal_px: 0.5 * sight.focal_px, ..sight.clone() }, &projection, 1024);
        assert!(missing(&coarser.tiles, &sight, &view) > 0, "{camera}");
        // With little room the view is coarser instead of too large.
        let few = imagery.choose(&sight, &projection, 6);
        assert!(few.tiles.len() <= 6 && few.bias > 0.0, "{camera}: {}", few.tiles.len());
    }
    // Nothing of it is seen.
    let (away, _) = sight("0,-6000,100,180,0,40", [320, 200]);
    assert_eq!(imagery.choose(&away, &projection, 1024).tiles.len(), 1);
}

#[test]
fn a_texel_is_the_mean_light_of_its_pixels() {
    // Rows of pixels, alternately black and white, are reduced to their mean light, and not to that of their shades.
    let imagery = imagery([802, 802], |_, y| if y % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
    assert_eq!(imagery.texels_per_sample, 2.0);
    let tile = imagery.resample(ImageTile { level: imagery.top, x: 0, y: 0 }).unwrap();
    let at = |tile: &[[u8; 4]], x: u32, y: u32| tile[((y + BORDER) * TILE_STRIDE + x + BORDER) as usize];
    let [grey, .., alpha] = at(&tile, 60, 60);
    assert!(grey.abs_diff(188) <= 3 && alpha == 255, "{grey}");
    assert!(grey.abs_diff(128) > 20, "planted: the mean of shades");
    // On level 0 a texel is a pixel.
    let tile = imagery.resample(ImageTile { level: 0, x: 1, y: 0 }).unwrap();
    for y in 10..20 {
        let shade = at(&tile, 30, y)[0];
        assert_eq!(shade, if y % 2 == 0 { 0 } else { 255 }, "row {y}");
    }
    // Beyond the image there is nothing.
    let tile = imagery.resample(ImageTile { level: 0, x: 3, y: 3 }).unwrap();
    assert_eq!((at(&tile, 10, 10)[3], at(&tile, 100, 100)[3]), (255, 0));
}
