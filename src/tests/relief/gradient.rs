//! Tests the gradient of depth and its blur.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::style::Style;
use hachure::tones::relief::gradient::{BLURRED_GRADIENT, DEPTH_GRADIENT};

use crate::tests::common::draw::{NOON, draw, floats, still};
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, grid_of};

const SIZE_PX: [u32; 2] = [240, 180];

/// Returns the text of a grey style whose light is relief with these keys.
pub fn text(keys: &str) -> String {
    format!(
        "name = \"relief\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nsoftness = 1\n\
         [light]\nwrap = 0.0\nexposure = 0.5\n[relief]\n{keys}\n"
    )
}

pub fn style(keys: &str) -> Style {
    Style::parse("relief", &text(keys)).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the texels of the gradient target. `steps` is the number of blur steps, which determines the target that
/// holds the result.
fn gradients(world: &mut World, camera: &str, keys: &str, steps: usize) -> Vec<[f32; 4]> {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style(keys), &NOON);
    let kind = if steps.is_multiple_of(2) { &DEPTH_GRADIENT } else { &BLURRED_GRADIENT };
    floats(&world.gpu, renderer.target(kind).unwrap())
}

fn at(x: usize, y: usize) -> usize {
    y * SIZE_PX[0] as usize + x
}

#[test]
fn planes_do_not_bend() {
    let slope = DVec2::new(0.3, -0.2);
    let Some(mut world) = World::new(grid_of(513, 513, 20.0, |x, y| slope.dot(DVec2::new(x, y))), 1.0) else { return };
    for camera in ["0,-2000,+300,0,-8,70", "0,0,4000,20,-70,50"] {
        let found = gradients(&mut world, camera, "scale_px = 0.0", 0);
        let seen: Vec<_> = found.iter().filter(|texel| texel[2] > 0.0).collect();
        let spread = |of: &dyn Fn(&[f32; 4]) -> f64| {
            let mut values: Vec<f64> = seen.iter().map(|texel| of(texel)).collect();
            values.sort_by(f64::total_cmp);
            // The border of the land has other normals, so the outer 2 % are ignored.
            let [low, high] = [values[values.len() / 50], values[values.len() * 49 / 50]];
            (high - low) / values[values.len() / 2].abs()
        };
        let own = spread(&|texel| texel[1].into());
        println!("{camera}: the gradient on a plane spreads by {own:.1e}");
        assert!(seen.len() > 8000 && own < 2e-3, "{own}");
        // Planted: the gradient of depth itself, which is the stored value times the square of depth.
        assert!(spread(&|texel| f64::from(texel[1]) / f64::from(texel[2] * texel[2])) > 0.1);
    }
}

#[test]
fn the_gradient_bends_as_the_hill_does() {
    let (hill, grid) = Hill::square(321, 10.0);
    let Some(mut world) = World::new(grid, 1.0) else { return };
    // From straight above, so high that perspective hardly matters.
    let height_m = 40_000.0;
    let found = gradients(&mut world, "0,0,40000,0,-90,3", "scale_px = 0.0", 0);
    let pixel_m = height_m * 2.0 * 1.5_f64.to_radians().tan() / f64::from(SIZE_PX[1]);
    let middle = DVec2::new(f64::from(SIZE_PX[0]), f64::from(SIZE_PX[1])) * 0.5;
    let (mut most, mut planted, mut count) = (0.0_f64, 0.0_f64, 0);
    for y in (20..160).step_by(3) {
        for x in (20..220).step_by(3) {
            let place = (DVec2::new(x as f64, y as f64) + 0.5 - middle) * DVec2::new(pixel_m, -pixel_m);
            if place.abs().max_element() > 1300.0 {
                continue;
            }
            let z = |dx: f64, dy: f64| hill.height_m(place.x + dx, place.y + dy);
            let exact = -pixel_m * (z(4.0, 0.0) + z(-4.0, 0.0) - 2.0 * z(0.0, 0.0)) / 16.0;
            let texel = |x: usize| found[at(x, y)];
            let own = -f64::from(texel(x + 1)[0] - texel(x - 1)[0]) / 2.0 / f64::from(texel(x)[2]);
            most = most.max((own - exact).abs());
            planted = planted.max((-own - exact).abs());
            count += 1;
        }
    }
    // The largest curvature of the hill, per pixel.
    let scale = 200.0 / 420.0 / 420.0 * pixel_m;
    println!(
        "{count} points: curvature is off by {:.1e} of the largest (planted {:.1})",
        most / scale,
        planted / scale
    );
    assert!(count > 1000 && most < 0.03 * scale && planted > scale);
}

#[test]
fn the_blur_stops_at_silhouettes() {
    // A wall of hills in front of a plain: the visible plain has a single gradient, however far it is blurred.
    let wall_m = |_: f64, y: f64| 300.0 * (-(y / 120.0).powi(2)).exp();
    let Some(mut world) = World::new(grid_of(513, 513, 20.0, wall_m), 1.0) else { return };
    let camera = "0,-1500,+700,0,-20,50";
    let sharp = gradients(&mut world, camera, "scale_px = 0.0", 0);
    // Standard deviations after each step: 0.7, 1, 1.7, 2.2, 3.6, 4.6, 7.4.
    let blurred = gradients(&mut world, camera, "scale_px = 7.0", 7);
    let world_y = |texel: [f32; 4], y: usize| {
        // The ray of a pixel in the middle column.
        let down = (y as f64 + 0.5 - 90.0) * 2.0 * 25_f64.to_radians().tan() / 180.0;
        let (sine, cosine) = (-20_f64.to_radians()).sin_cos();
        let ray = DVec3::new(0.0, cosine + down * sine, sine - down * cosine);
        -1500.0 + ray.y / f64::from(texel[2])
    };
    let (mut plain, mut hills, mut plains) = (0.0_f64, 0.0_f64, 0);
    for y in 0..180 {
        let pixel = at(120, y);
        let north_m = world_y(sharp[pixel], y);
        let change = f64::from((sharp[pixel][1] - blurred[pixel][1]).abs() / sharp[pixel][1].abs().max(1e-9));
        if sharp[pixel][2] > 0.0 && (600.0..3000.0).contains(&north_m) {
            plain = plain.max(change);
            plains += 1;
        } else if north_m.abs() < 300.0 {
            hills = hills.max(change);
        }
    }
    println!("{plains} pixels of the plain change by {plain:.3}, those of the hills by {hills:.2}");
    assert!(plains > 10 && plain < 0.02 && hills > 0.05);
}

#[test]
fn what_is_said_to_be_coarser_is() {
    let (_, grid) = Hill::square(321, 10.0);
    let Some(mut world) = World::new(grid, 1.0) else { return };
    let camera = "0,-2600,+500,0,-10,50";
    let scales = |world: &mut World, keys: &str| -> Vec<f32> {
        let found = gradients(world, camera, keys, 0);
        found.iter().filter(|texel| texel[2] > 0.0).map(|texel| texel[3].floor() / 256.0).collect()
    };
    let mean = |scales: &[f32]| scales.iter().sum::<f32>() / scales.len() as f32;
    let even = scales(&mut world, "scale_px = 0.0\ncoarser_far = 4.0");
    assert!(even.iter().all(|scale| *scale == 0.0));
    let even = scales(&mut world, "scale_px = 0.3");
    assert!(even.iter().all(|scale| (scale - 0.3).abs() < 0.01), "{:?}", mean(&even));
    for keys in ["coarser_far = 4.0", "coarser_level = 4.0"] {
        let coarser = scales(&mut world, &format!("scale_px = 0.3\n{keys}"));
        let [least, most] = [f32::min, f32::max].map(|pick| coarser.iter().copied().reduce(pick).unwrap());
        assert!(mean(&coarser) > mean(&even) && most > least + 0.01 && most <= 1.51, "{keys}: {least} to {most}");
    }
}
