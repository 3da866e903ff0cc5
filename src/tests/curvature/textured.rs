//! Pixel lines drawn with a stroke texture: they have as much ink as strokes have, and the texture runs along them.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::lines::curvature::CURVATURE_LINE;
use hachure::lines::strokes::texture::{Brush, grow};
use hachure::style::texture::Recipe;
use hachure::style::{Detector, Style};
use hachure::surface::DISTANCE;

use crate::tests::common::draw::{NOON, draw, floats, still};
use crate::tests::common::{World, all_lines, full, grid_of};
use crate::tests::helpers::shapes;

const SIZE_PX: [u32; 2] = [480, 480];
const RADIUS_M: f64 = 100.0;
const AWAY_M: f64 = 300.0;
const WIDTH_PX: f64 = 16.0;
/// Number of sectors of the circle that are compared.
const SECTORS: usize = 8;

fn style(texture: Option<&str>) -> Style {
    let mut style = all_lines("lsa");
    style.lines_mut().unwrap().detector = Detector::Curvature;
    style.curvature.width_px = WIDTH_PX as f32;
    style.curvature.suggestive = 0.0;
    style.curvature.texture_name = texture.map(str::to_owned);
    style.curvature.texture = texture.map(|name| Recipe::load(name, std::path::Path::new("")).unwrap());
    style
}

/// The outline of a ball in the centre of the picture.
struct Outline {
    line: Vec<f64>,
    radius_px: f64,
}

impl Outline {
    /// Returns the ink at an angle, `inside_px` inside the outline.
    fn ink(&self, angle: f64, inside_px: f64) -> f64 {
        let px = DVec2::from_angle(angle) * (self.radius_px - inside_px) + DVec2::splat(0.5 * f64::from(SIZE_PX[0]));
        self.line[px.y as usize * SIZE_PX[0] as usize + px.x as usize]
    }

    /// Returns the mean change of ink for a step along the line, or across it, in each sector.
    fn changes(&self, along_px: f64, across_px: f64) -> [f64; SECTORS] {
        std::array::from_fn(|sector| {
            let steps = 400;
            let changes = (0..steps).flat_map(|step| {
                let turn = (sector as f64 + f64::from(step) / f64::from(steps)) / SECTORS as f64;
                let angle = turn * std::f64::consts::TAU;
                [6.0, 8.0, 10.0].map(|inside_px| {
                    let there = self.ink(angle + along_px / self.radius_px, inside_px + across_px);
                    (self.ink(angle, inside_px) - there).abs()
                })
            });
            changes.sum::<f64>() / (3 * steps) as f64
        })
    }

    fn mean(&self) -> f64 {
        let places = (0..2000).flat_map(|i| [7.0, 8.0, 9.0].map(|inside_px| (f64::from(i) * 0.00314, inside_px)));
        places.map(|(angle, inside_px)| self.ink(angle, inside_px)).sum::<f64>() / 6000.0
    }
}

#[test]
fn textures_run_along_lines_of_pixels() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let ball = Arc::new(shapes::mesh(shapes::sphere(5)));
    let eye_m = DVec3::new(0.0, -1000.0, 1500.0);
    shapes::place(&mut world, &ball, &shapes::stance(eye_m + DVec3::Y * AWAY_M, 0.0, RADIUS_M));
    let pose = world.pose("0,-1000,1500,0,0,60");
    let view = still(pose, SIZE_PX);
    let radius_px = view.focal_px() * (RADIUS_M / AWAY_M).asin().tan();
    let mut outline = |texture| {
        let mut style = style(texture);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        // Lines are found before water and tones are drawn.
        if !full() {
            style.set_water(None);
            renderer.set_only_strokes(true);
        }
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
        let line = floats::<1>(&world.gpu, renderer.target(&CURVATURE_LINE).unwrap());
        Outline { line: line.into_iter().map(|[ink]| ink.into()).collect(), radius_px }
    };
    let solid = outline(None);
    assert!(solid.mean() > 0.99, "{}", solid.mean());
    for name in ["brush", "charcoal"].into_iter().take(if full() { 2 } else { 1 }) {
        let drawn = outline(Some(name));
        let recipe = Recipe::load(name, std::path::Path::new("")).unwrap();
        let expected = grow(&recipe)[0].mean_ink(&Brush::of(&recipe), 1.0);
        let by = |range: [f64; SECTORS]| {
            (range.iter().copied().fold(f64::INFINITY, f64::min), range.iter().copied().fold(0.0, f64::max))
        };
        let (along, across) = (by(drawn.changes(4.0, 0.0)), by(drawn.changes(0.0, 4.0)));
        println!(
            "{name}: ink {:.3}, a wide stroke has {expected:.3}; a step of 4 px along it changes ink by {:.3} to {:.3}, across it by \
             {:.3} to {:.3}",
            drawn.mean(),
            along.0,
            along.1,
            across.0,
            across.1
        );
        assert!((drawn.mean() - expected).abs() < 0.06, "{name}");
        // The change is similar in all sectors, so the texture does not swirl. The hairs of a brush run along the line;
        // solid lines do not change at all.
        assert!(
            along.1 < 2.2 * along.0 && along.0 > 0.0,
            "{name}: the change of ink along the line depends on the sector: {along:?}"
        );
        assert!(name != "brush" || along.1 < 0.6 * across.0);
        assert!(solid.changes(4.0, 0.0)[0] < 1e-3);
    }
}

/// Height of a ridge from west to east that is the same everywhere along it.
fn ridge_m(_: f64, north_m: f64) -> f64 {
    120.0 * (-(north_m / 150.0).powi(2)).exp()
}

/// Correlation of two sequences, of which the second one begins `shift` places later.
fn correlation(a: &[f64], b: &[f64], shift: isize) -> f64 {
    let pairs: Vec<(f64, f64)> = a
        .iter()
        .enumerate()
        .filter_map(|(place, value)| Some((*value, *b.get(usize::try_from(place as isize + shift).ok()?)?)))
        .collect();
    let count = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let (mean_a, mean_b) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let product = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let both = product(&|(a, b)| (a - mean_a) * (b - mean_b));
    both / (product(&|(a, _)| (a - mean_a).powi(2)) * product(&|(_, b)| (b - mean_b).powi(2))).sqrt()
}

#[test]
fn textures_stay_on_the_land_as_the_camera_moves() {
    const MOVED_M: f64 = 21.0;
    let Some(mut world) = World::new(grid_of(401, 401, 4.0, ridge_m), 0.2) else { return };
    let mut style = style(Some("charcoal"));
    style.curvature.width_px = 12.0;
    // The mean ink of each column, and the step from pixel to pixel along the ridge.
    let mut columns = |east_m: f64| {
        let view = still(world.pose(&format!("{east_m},-420,190,0,-12,50")), SIZE_PX);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
        let line = floats::<1>(&world.gpu, renderer.target(&CURVATURE_LINE).unwrap());
        let distance_m = floats::<1>(&world.gpu, renderer.target(&DISTANCE).unwrap());
        let width = SIZE_PX[0] as usize;
        let inked = (0..line.len()).filter(|pixel| line[*pixel][0] > 0.5);
        let away_m: Vec<f64> = inked.map(|pixel| distance_m[pixel][0].into()).collect();
        let away_m = away_m.iter().sum::<f64>() / away_m.len() as f64;
        let inks: Vec<f64> = (0..width)
            .map(|column| line.iter().skip(column).step_by(width).map(|[ink]| f64::from(*ink)).sum())
            .collect();
        (inks, away_m / view.focal_px())
    };
    let (before, step_m) = columns(0.0);
    let (after, _) = columns(MOVED_M);
    assert!(before.iter().sum::<f64>() > 2.0 * f64::from(SIZE_PX[0]));
    // What was seen in a column is seen to the left of it.
    let expected = -MOVED_M / step_m;
    let best =
        (-100..=100).max_by(|a, b| correlation(&before, &after, *a).total_cmp(&correlation(&before, &after, *b)));
    let best = best.unwrap();
    let [there, page] = [best, 0].map(|shift| correlation(&before, &after, shift));
    println!(
        "the ridge moves by {expected:.1} px, its texture by {best} px ({there:.2}); fixed to the page: {page:.2}"
    );
    assert!((best as f64 - expected).abs() < 1.0 && there > 0.7, "{best} px instead of {expected:.1}");
    // Planted: a texture that is fixed to the page is where it was.
    assert!(page < 0.5);
}
