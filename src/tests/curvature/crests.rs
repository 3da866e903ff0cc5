//! Crests are lighter and hollows darker, in proportion to the mean curvature of closed forms.

use glam::DVec2;
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::style::{Style, Tone};
use hachure::surface::curvature::{SHAPE_BEND, SHAPE_NORMAL};
use hachure::tones::crests::CREST_LIGHT;

use crate::tests::common::draw::{NOON, draw, floats, still};
use crate::tests::common::{World, grid_of};
use crate::tests::curvature::{LANDS, RADIUS_M, SIZE_PX, jet, principal_of, world_of};

const CRESTS: f32 = 0.8;
/// The constant of `shaders/tones/crests.wgsl`.
const HALF_AT: f64 = 0.15;

fn style(crests: f32, level_deg: f32) -> Style {
    let mut style = crate::tests::common::absolute("cartoon").without(&["water", "strokes", "lines"]);
    (style.light.crests, style.light.crests_px, style.light.level_deg) = (crests, 3.0, level_deg);
    let Tone::Toon(toon) = &mut style.tone else { unreachable!("the style cartoon has toon shading") };
    toon.steps = 0;
    style
}

fn picture(world: &mut World, camera: &str, style: &Style) -> (Renderer, Vec<u8>) {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let view = still(world.pose(camera), SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
    let picture = read(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap();
    (renderer, picture)
}

#[test]
fn crests_gain_what_their_mean_curvature_says() {
    for land in &LANDS {
        let Some(mut world) = world_of(land, 0.02 * RADIUS_M) else { return };
        let (renderer, _) = picture(&mut world, "0,-1400,1400,0,-45,40", &style(CRESTS, 0.0));
        let gains = floats::<1>(&world.gpu, renderer.target(&CREST_LIGHT).unwrap());
        let [normals, bends] =
            [&SHAPE_NORMAL, &SHAPE_BEND].map(|kind| floats::<4>(&world.gpu, renderer.target(kind).unwrap()));
        let (pose, view) = (world.pose("0,-1400,1400,0,-45,40"), still(world.pose("0,-1400,1400,0,-45,40"), SIZE_PX));
        let (mut worst, mut planted, mut count) = (0.0_f64, 0.0_f64, 0);
        let wide = SIZE_PX[0].div_ceil(4) as usize + 1;
        for (i, [_, _, _, depth_m]) in normals.iter().enumerate().filter(|(_, normal)| normal[3] > 0.0) {
            // Gains are interpolated between blocks; only at the pixel of a block is the gain that of the block.
            let [x, y] = [i % wide, i / wide].map(|side| side * 4 + 2);
            if x >= SIZE_PX[0] as usize || y >= SIZE_PX[1] as usize {
                continue;
            }
            let ray = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let map = (pose.position_m + ray * f64::from(*depth_m)).truncate();
            let sample_m = f64::from(bends[i][3]);
            let is_smooth = (land.principal)(map).is_some() && map.abs().max_element() < 4.0 * (RADIUS_M - sample_m);
            if !is_smooth || sample_m > 0.1 * RADIUS_M {
                continue;
            }
            let ([most, least], _) = principal_of(&jet(land.height_m, map));
            let turn = 0.5 * (most + least) * sample_m;
            let expected = f64::from(CRESTS) * turn / (HALF_AT + turn.abs());
            let found = f64::from(gains[y * SIZE_PX[0] as usize + x][0]);
            worst = worst.max((found - expected).abs());
            planted = planted.max((found + expected).abs());
            count += 1;
        }
        println!("{}: {count} points, largest error of a gain {worst:.4}", land.name);
        assert!(count > 300 && worst < 0.01, "{}: largest error of a gain {worst}, expected less than 0.01", land.name);
        // The mean curvature of a saddle is nearly zero.
        assert!(
            planted > 5.0 * worst || land.name.contains("saddle"),
            "{}: gains of the opposite sign pass",
            land.name
        );
    }
}

#[test]
fn planes_and_level_land_gain_nothing() {
    let Some(mut plane) = World::new(grid_of(321, 321, 10.0, |x, y| 0.3 * x + 0.2 * y), 1.0) else { return };
    let camera = "0,-900,900,0,-45,50";
    let [plain, crests] = [0.0, 1.0].map(|crests| picture(&mut plane, camera, &style(crests, 0.0)).1);
    let off = plain.iter().zip(&crests).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(off <= 1, "crests change the picture of a plane, by {off}");
    // Low swells, of up to 3 degrees.
    let swells = |x: f64, y: f64| 4.0 * (x / 80.0).sin() + y * 0.0;
    let Some(mut low) = World::new(grid_of(321, 321, 10.0, swells), 1.0) else { return };
    let [plain, crests] = [0.0, 1.0].map(|crests| picture(&mut low, camera, &style(crests, 4.0)).1);
    assert!(plain == crests, "crests change land that is white because of its slope");
    let [plain, crests] = [0.0, 1.0].map(|crests| picture(&mut low, camera, &style(crests, 0.0)).1);
    assert!(plain != crests, "without the limit on slope, crests do not show on swells");
}
