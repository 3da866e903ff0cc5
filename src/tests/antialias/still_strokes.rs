//! The coverage of strokes is exact at their edges, and strokes stay where they are when the lens is jittered by a
//! fraction of a pixel.

use glam::DVec2;
use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::stroke::INK;
use hachure::scene::view::View;
use hachure::style::Style;

use crate::tests::antialias::SIZE_PX;
use crate::tests::common::draw::{NOON, draw};
use crate::tests::common::{self, World};

fn ink(world: &mut World, style: &Style, jitter_px: DVec2) -> Vec<f64> {
    let pose = world.pose(crate::tests::antialias::VIEW);
    let view = View { jitter_px, ..View::whole(pose, pose, SIZE_PX) };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
    let halves: Vec<u16> = read_as(&world.gpu, renderer.target(&INK).unwrap(), [0, 0], SIZE_PX).unwrap();
    halves.into_iter().map(|bits| half::f16::from_bits(bits).to_f64()).collect()
}

/// Returns by how many pixels `to` is shifted against `from`, by least squares (Lucas and Kanade 1981).
fn moved_px(from: &[f64], to: &[f64]) -> DVec2 {
    let width = SIZE_PX[0] as usize;
    let (mut product, mut square) = ([0.0; 3], DVec2::ZERO);
    for pixel in (width + 1..from.len() - width - 1).filter(|pixel| (1..width - 1).contains(&(pixel % width))) {
        let slope = |step: usize| (from[pixel + step] - from[pixel - step]) / 2.0;
        let gradient = DVec2::new(slope(1), slope(width));
        square += gradient * (from[pixel] - to[pixel]);
        product = [
            product[0] + gradient.x * gradient.x,
            product[1] + gradient.x * gradient.y,
            product[2] + gradient.y * gradient.y,
        ];
    }
    let [xx, xy, yy] = product;
    DVec2::new(yy * square.x - xy * square.y, xx * square.y - xy * square.x) / (xx * yy - xy * xy)
}

#[test]
fn strokes_are_not_moved() {
    let Some(mut world) = crate::tests::antialias::rough() else { return };
    // The lines that a cap on crowded lines leaves out depend a little on the depth picture.
    let style = common::all_lines("strokes");
    let still = ink(&mut world, &style, DVec2::ZERO);
    let jitters_px = [DVec2::new(-0.4, 0.3), DVec2::new(0.4, 0.0), DVec2::new(0.1, -0.5)];
    for jitter_px in jitters_px.into_iter().take(if common::full() { 3 } else { 1 }) {
        let found_px = moved_px(&still, &ink(&mut world, &style, jitter_px));
        println!("jitter {jitter_px:.2}: strokes are shifted by {found_px:.3}");
        assert!(found_px.length() < 0.1, "strokes are shifted by {found_px} px");
        // Planted error: strokes that shift with the picture, interpolated between its pixels.
        let width = SIZE_PX[0] as usize;
        let at = |pixel: usize, step: f64, stride: usize| {
            let neighbour =
                if step > 0.0 { pixel.saturating_sub(stride) } else { (pixel + stride).min(still.len() - 1) };
            still[pixel] + (still[neighbour] - still[pixel]) * step.abs()
        };
        let planted: Vec<f64> = (0..still.len())
            .map(|pixel| at(pixel, jitter_px.x, 1) + at(pixel, jitter_px.y, width) - still[pixel])
            .collect();
        assert!(moved_px(&still, &planted).distance(jitter_px) < 0.1);
    }
}
