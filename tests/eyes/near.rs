//! Things half a metre to ten metres away: contours lie elsewhere on them for each eye.

use std::sync::Arc;

use super::*;
use crate::common::shapes;

const SIZE_PX: [u32; 2] = [480, 270];
const IPD_M: f64 = 0.065;

/// High above the land, which is far below: what is seen is the thing alone, the sky and the land.
const CAMERA: &str = "0,0,700,20,-20,60";

/// So far away, and so large.
const THINGS: [(f64, f64); 4] = [(0.2, 0.06), (0.5, 0.12), (2.0, 0.6), (10.0, 3.0)];

#[test]
fn near_things_have_the_same_lines_for_both_eyes() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let pose = world.pose(CAMERA);
    for (shape, soup) in [("ball", shapes::sphere(5)), ("cube", shapes::cube())] {
        let mesh = Arc::new(shapes::mesh(soup));
        for (away_m, radius_m) in THINGS {
            let stance = shapes::stance(pose.position_m + pose.forward * away_m, 30.0, radius_m);
            shapes::place(&mut world, &mesh, &stance);
            let rig = rig(pose, IPD_M, SIZE_PX);
            let mut of = |style: &Style| agreement(&draw(&world.gpu, &mut world.surfaces, style, &rig));
            let (alone, full) = (of(&ink_alone()), of(&Style::load("ink").unwrap()));
            let charcoal = Style::load("charcoal").unwrap();
            let strokes = of(&charcoal);
            let part = |metrics: &Metrics, name: &str| metrics[name].unwrap_or(f64::NAN);
            println!(
                "{shape} {away_m} m away: orphans {:.3} %, alone {:.3} %, coverage {:.3} of that alone; strokes: orphans \
                 {:.3} %, ink correlates by {:.3}, other identity {:.2} %",
                100.0 * part(&full, "orphans"),
                100.0 * part(&alone, "orphans"),
                part(&full, "line_coverage") / part(&alone, "line_coverage"),
                100.0 * part(&strokes, "orphans"),
                part(&strokes, "line_correlation"),
                100.0 * part(&strokes, "other_identity")
            );
            // As near as a hand's breadth, all of the ball is between the contours of both eyes.
            let most = if away_m < 0.5 { 0.05 } else { 0.01 };
            assert!(part(&full, "orphans") <= most, "{shape} {away_m}");
            assert!(part(&strokes, "orphans") <= most, "{shape} {away_m}");
            assert!(away_m < 0.5 || part(&strokes, "line_correlation") >= 0.95, "{shape} {away_m}");
            // Planted: strokes of the right eye that lie four pixels lower.
            let mut eyes = draw(&world.gpu, &mut world.surfaces, &charcoal, &rig);
            eyes[1].ink.as_mut().unwrap().rotate_right(4 * SIZE_PX[0] as usize);
            let lower = agreement(&eyes);
            assert!(part(&lower, "orphans") > 0.05 && part(&lower, "line_correlation") < 0.9, "{shape} {away_m}");
        }
    }
}
