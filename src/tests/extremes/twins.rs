//! Positions, normals, curvature and contour lines of extreme land compared with the same in f64.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::target::TargetKind;
use hachure::picture::PartRule;
use hachure::scene::view::Pose;
use hachure::source::HeightGrid;
use hachure::style::Style;
use hachure::style::layers::HEIGHT_INK;
use hachure::surface::curvature::{SHAPE_BEND, SHAPE_NORMAL};
use hachure::surface::form::FORM_NORMAL;

use super::lands::{FAR_M, Land, SAMPLES, SPACING_M};
use crate::tests::common::draw::{NOON, draw, floats, north_west, places_m, still};
use crate::tests::common::shot::{ink, shoot_style};
use crate::tests::common::{self, full, grid_of, quantile};

const SIZE_PX: [u32; 2] = [96, 72];

#[test]
fn positions_are_those_of_the_land() {
    let mut style = ink("footprint");
    if !full() {
        // Lakes are then drawn as land, at the same heights.
        style.set_water(None);
    }
    let spacings_m = if full() { &[SPACING_M, 0.001, 10_000.0][..] } else { &[0.001, 10_000.0] };
    let cameras = [(900.0, -20.0, 55.0), (900.0, -20.0, 1.0), (900.0, -50.0, 150.0), (3000.0, -90.0, 60.0)];
    for (number, spacing_m) in spacings_m.iter().enumerate() {
        let Some(mut land) = Land::of_spacing(*spacing_m) else { return };
        let mut renderer = None;
        // In the fast tier each land has another extreme lens.
        let cameras = if full() { &cameras[..] } else { &cameras[1 + number..][..1] };
        for &(z_m, pitch_deg, fov_deg) in cameras {
            let at = land.middle_m + DVec2::new(100.0, -900.0) * land.factor;
            // The land of 10 km between samples is low for its width.
            let up_m = z_m * land.factor.min(4.0);
            let pose = land.world.pose(&format!("{},{},{up_m:+},17,{pitch_deg},{fov_deg}", at.x, at.y));
            let parts = PartRule::default();
            let shot = shoot_style(&mut land.world, &mut renderer, pose, pose, SIZE_PX, &style, &parts);
            let terrain = &land.world.surfaces.terrain;
            let earth = terrain.earth_curvature(pose.position_m.z);
            let errors_px = |raised_m: f64| {
                let error_px = |pixel: usize| {
                    let flat = earth.unbend(shot.position_m[pixel]) + pose.position_m;
                    let off_m = (flat.z + raised_m - terrain.height_m(flat.truncate())?).abs();
                    Some(off_m * shot.focal_px() / shot.position_m[pixel].length())
                };
                let ground = (0..shot.depth_m.len()).filter(|&pixel| !shot.is_sky(pixel));
                let mut errors: Vec<f64> = ground.filter_map(error_px).collect();
                assert!(errors.len() > 1500, "{}: {} pixels of ground", land.name, errors.len());
                quantile(&mut errors, 0.999)
            };
            let error_px = errors_px(0.0);
            println!("{}, lens {fov_deg}, pitch {pitch_deg}: {error_px:.3} px", land.name);
            assert!(error_px <= 1.0, "{}, lens {fov_deg}, pitch {pitch_deg}: {error_px} px", land.name);
            // Planted: land that is higher by three pixels.
            assert!(errors_px(3.0 * up_m.abs() / shot.focal_px()) > 1.0);
        }
    }
}

/// Principal radii of a saddle, in samples: those of its cross-sections along east and north.
const RADII: [f64; 2] = [160.0, -240.0];

/// A saddle, whose derivatives are known, and on which splines of any spacing are exact.
struct Saddle {
    land: Land,
    spacing_m: f64,
}

/// Returns the heights of the saddle.
fn saddle_grid(spacing_m: f64) -> HeightGrid {
    grid_of(SAMPLES, SAMPLES, spacing_m, move |x, y| {
        spacing_m * 200.0 - 0.5 * (x * x / (RADII[0] * spacing_m) + y * y / (RADII[1] * spacing_m))
    })
}

impl Saddle {
    fn all() -> Option<Vec<Self>> {
        let of = |spacing_m: f64| Some(Self { land: Land::of_grid(saddle_grid(spacing_m), spacing_m)?, spacing_m });
        Some(vec![of(SPACING_M)?, of(0.001)?, of(10_000.0)?])
    }

    fn slope(&self, world: DVec2) -> DVec2 {
        let at = world - self.land.middle_m;
        -at / (DVec2::from_array(RADII) * self.spacing_m)
    }

    /// Returns the mean curvature and the product of the principal curvatures, of spheres positive.
    fn curvature(&self, world: DVec2) -> [f64; 2] {
        let (slope, second) = (self.slope(world), DVec2::from_array(RADII).recip() / self.spacing_m);
        let stretch = 1.0 + slope.length_squared();
        let mean =
            ((1.0 + slope.y * slope.y) * second.x + (1.0 + slope.x * slope.x) * second.y) / (2.0 * stretch.powf(1.5));
        [mean, second.x * second.y / (stretch * stretch)]
    }

    fn pose(&self, camera: [f64; 5]) -> Pose {
        let [east, north, up, pitch_deg, fov_deg] = camera;
        let at = self.land.middle_m + DVec2::new(east, north) * self.spacing_m;
        self.land.world.pose(&format!("{},{},{:+},17,{pitch_deg},{fov_deg}", at.x, at.y, up * self.spacing_m))
    }
}

/// Cameras in samples and degrees: east, north, height above the ground, pitch and field of view.
const CAMERAS: [[f64; 5]; 3] =
    [[0.0, -60.0, 40.0, -40.0, 60.0], [0.0, 0.0, 80.0, -90.0, 60.0], [5.0, -90.0, 60.0, -31.0, 10.0]];
/// Side of a block of pixels for which the form of the land is computed.
const BLOCK_PX: u32 = 4;

/// The form of the land in a block of pixels.
struct Block {
    /// Index among the texels of its picture.
    texel: usize,
    /// East and north.
    at_m: DVec2,
    normal: DVec3,
}

impl Saddle {
    /// Draws a style, and returns the blocks of the picture `normals`, of normals and distances, that have samples of the
    /// land on all sides.
    fn draw(&mut self, renderer: &mut Renderer, camera: [f64; 5], style: &Style, normals: &TargetKind) -> Vec<Block> {
        let pose = self.pose(camera);
        let (view, gpu) = (still(pose, SIZE_PX), self.land.world.gpu.clone());
        draw(&gpu, &mut self.land.world.surfaces, renderer, &view, style, &north_west());
        let wide = SIZE_PX[0].div_ceil(BLOCK_PX) as usize + 1;
        let mut blocks = Vec::new();
        for (texel, normal) in floats::<4>(&gpu, renderer.target(normals).unwrap()).into_iter().enumerate() {
            let [x, y, z, along_m] = normal.map(f64::from);
            let middle = DVec2::new((texel % wide) as f64, (texel / wide) as f64) * f64::from(BLOCK_PX) + 2.5;
            if along_m <= 0.0 || middle.x >= f64::from(SIZE_PX[0]) || middle.y >= f64::from(SIZE_PX[1]) {
                continue;
            }
            let at_m = (pose.position_m + view.ray(middle) * along_m).truncate();
            if ((at_m - self.land.middle_m).abs() / self.spacing_m).max_element() < 100.0 {
                blocks.push(Block { texel, at_m, normal: DVec3::new(x, y, z) });
            }
        }
        assert!(blocks.len() > 150, "{}, {camera:?}: {} blocks", self.land.name, blocks.len());
        blocks
    }

    /// Returns the angle between the normals of blocks and those of a saddle with radii that are larger by a factor, in
    /// degrees, that 99 % do not exceed.
    fn turn_deg(&self, blocks: &[Block], factor: f64) -> f64 {
        let turn_deg = |block: &Block| {
            let slope = self.slope(block.at_m) / factor;
            DVec3::new(-slope.x, -slope.y, 1.0).angle_between(block.normal).to_degrees()
        };
        quantile(&mut blocks.iter().map(turn_deg).collect::<Vec<_>>(), 0.99)
    }
}

#[test]
fn curvature_is_that_of_the_land() {
    let Some(saddles) = Saddle::all() else { return };
    let mut style = common::all_lines("strokes");
    style.strokes_mut().unwrap().suggestive_px = Some(4.0);
    style.set_water(None);
    for mut saddle in saddles {
        for camera in CAMERAS {
            let gpu = saddle.land.world.gpu.clone();
            let mut renderer = Renderer::new(&gpu).unwrap();
            let mut blocks = saddle.draw(&mut renderer, camera, &style, &SHAPE_NORMAL);
            let bends = floats::<4>(&gpu, renderer.target(&SHAPE_BEND).unwrap());
            // A form of large samples needs more land around it: at its coarsest levels the samples are the land's own.
            let sample_m = |block: &Block| f64::from(bends[block.texel][3]);
            let most_m = 126.0 * saddle.spacing_m;
            let middle_m = saddle.land.middle_m;
            blocks.retain(|block| (block.at_m - middle_m).abs().max_element() + 6.0 * sample_m(block) < most_m);
            assert!(blocks.len() > 100, "{}, {camera:?}: {} blocks", saddle.land.name, blocks.len());
            // Errors as a part of the geometric mean of the principal curvatures.
            let off = |factor: f64| {
                let off = |block: &Block| {
                    let [uu, uv, vv, _] = bends[block.texel].map(f64::from);
                    let [mean, product] = saddle.curvature(block.at_m);
                    let scale = product.abs().sqrt();
                    let off_mean = (0.5 * (uu + vv) - factor * mean).abs() / scale;
                    let off_product = (uu * vv - uv * uv - factor * factor * product).abs() / (scale * scale);
                    off_mean.max(off_product)
                };
                quantile(&mut blocks.iter().map(off).collect::<Vec<_>>(), 0.9)
            };
            let (error, turn_deg, name) = (off(1.0), saddle.turn_deg(&blocks, 1.0), &saddle.land.name);
            println!("{name}, {camera:?}: curvature off by {error:.2e}, normals by {turn_deg:.2e} degrees");
            assert!(error < 0.01 && turn_deg < 0.02, "{name}, {camera:?}: {error} and {turn_deg} degrees");
            // Planted: a saddle of other radii.
            assert!(off(1.1) > 0.01 && saddle.turn_deg(&blocks, 1.1) > 0.02);
        }
    }
}

#[test]
fn light_falls_on_the_form_of_the_land() {
    let Some(saddles) = Saddle::all() else { return };
    let mut style = Style::load("pencil").unwrap();
    style.light.turn_deg = 0.0;
    if !full() {
        // The form depends on neither layers nor shadows.
        style = style.without(&["hatching", "drainage", "water", "strokes"]);
        (style.light.shadow, style.light.occlusion, style.light.crests) = (0.0, 0.0, 0.0);
    }
    for mut saddle in saddles {
        for camera in CAMERAS {
            let mut renderer = Renderer::new(&saddle.land.world.gpu).unwrap();
            let blocks = saddle.draw(&mut renderer, camera, &style, &FORM_NORMAL);
            let (turn_deg, name) = (saddle.turn_deg(&blocks, 1.0), &saddle.land.name);
            println!("{name}, {camera:?}: the form's normal is off by {turn_deg:.2e} degrees");
            assert!(turn_deg < 0.02, "{name}, {camera:?}: {turn_deg} degrees");
            // Planted: a saddle of other radii.
            assert!(saddle.turn_deg(&blocks, 1.1) > 0.02);
        }
    }
}

#[test]
fn contour_lines_are_at_their_heights_far_from_the_origin() {
    // A slope with waves, so that lines are apart and not straight.
    let height_m = |x: f64, y: f64| 700.0 + 0.16 * x - 0.07 * y + 60.0 * (x / 900.0).sin() * (y / 1100.0).cos();
    let interval_m = 40.0;
    let Some(mut land) = Land::far_of(&grid_of(SAMPLES, SAMPLES, SPACING_M, height_m)) else { return };
    let mut style = Style::load("pen").unwrap();
    if !full() {
        // Contour lines depend on neither tones nor other layers.
        let lines = style.lowest_height_lines().cloned();
        style = Style::load("plain").unwrap();
        style.set_height_lines(lines);
    }
    style.lowest_height_lines_mut().unwrap().interval_m = interval_m as f32;
    let size_px = [200, 150];
    for camera in ["0,0,4000,0,-90,50", "0,-2500,2600,0,-40,50"] {
        let mut numbers: Vec<f64> = camera.split(',').map(|number| number.parse().unwrap()).collect();
        numbers[0] += FAR_M;
        let camera: Vec<String> = numbers.iter().map(f64::to_string).collect();
        let pose = land.world.pose(&camera.join(","));
        let gpu = land.world.gpu.clone();
        let mut renderer = Renderer::new(&gpu).unwrap();
        draw(&gpu, &mut land.world.surfaces, &mut renderer, &still(pose, size_px), &style, &NOON);
        let ink = floats::<1>(&gpu, renderer.target(&HEIGHT_INK).unwrap());
        let places = places_m(&gpu, &renderer, pose.position_m);
        let width = size_px[0] as usize;
        // Toward its border the land fades into the plain.
        let half_m = 0.5 * f64::from(SAMPLES) * SPACING_M - 8.0 * SPACING_M;
        let height_at = |i: usize| {
            let at = places[i]?.truncate() - DVec2::new(FAR_M, 0.0);
            if at.abs().max_element() < half_m { Some(height_m(at.x, at.y)) } else { None }
        };
        let astray = |from_m: f64| {
            let (mut inked, mut astray) = (0, 0);
            for i in (width..places.len() - width).filter(|i| i % width > 0 && i % width < width - 1) {
                let around = [i, i - 1, i + 1, i - width, i + width].map(height_at);
                let [Some(here), Some(west), Some(east), Some(north), Some(south)] = around else { continue };
                if ink[i][0] < 0.4 {
                    continue;
                }
                let rise_m = 0.5 * (east - west).hypot(south - north);
                let above = (here - from_m) / interval_m;
                inked += 1;
                astray += usize::from((above - above.round()).abs() * interval_m > 1.2 * rise_m);
            }
            assert!(inked > 500, "{inked} pixels have ink");
            astray as f64 / f64::from(inked)
        };
        let (found, planted) = (astray(0.0), astray(0.4 * interval_m));
        println!(
            "contour lines 1e7 m from the origin: {:.2} % astray, {:.0} % with a planted error",
            100.0 * found,
            100.0 * planted
        );
        assert!(found < 0.01 && planted > 0.3, "{found} {planted}");
    }
}
