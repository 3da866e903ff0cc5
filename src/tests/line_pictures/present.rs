//! Tests the presentation of a picture to a window: scaled, and encoded in sRGB where the window's format does not do
//! it.

use hachure::composite::PICTURE;
use hachure::composite::present::{PresentPass, Shown};
use hachure::gpu::readback::read;
use hachure::gpu::target::{Group, Target, TargetKind};
use hachure::picture::{eyes, srgb8};
use hachure::scene::anaglyph::Glasses;

use crate::tests::line_pictures::{Bench, SIZE_PX, bits, chance, inside, places};

/// Returns the sRGB value, from 0 to 255.
fn srgb(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    255.0 * if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn the_window_shows_the_picture() {
    let Some(bench) = Bench::new() else { return };
    let texels: Vec<[half::f16; 4]> =
        places().map(|(x, y)| std::array::from_fn(|i| half::f16::from_f64(1.1 * chance(x, y, i as i64)))).collect();
    let picture = bench.picture(&PICTURE, SIZE_PX, &bits(&texels));
    let exact: Vec<[f64; 4]> = texels.iter().map(|texel| texel.map(half::f16::to_f64)).collect();
    for window_px in [SIZE_PX, [2 * SIZE_PX[0], 2 * SIZE_PX[1]], [40, 57]] {
        for format in [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Rgba8UnormSrgb] {
            let window = Target::new(
                &bench.gpu,
                &TargetKind::attachment("window", format, Group::Whole.shows("The window")),
                window_px,
            );
            let mut encoder = bench.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let shown = Shown::One(&picture);
            PresentPass::new(&bench.gpu, format).run(&bench.gpu, &mut encoder, shown, &window.view, window_px);
            bench.gpu.queue.submit([encoder.finish()]);
            let shown = read(&bench.gpu, &window, [0, 0], window_px).unwrap();
            bench.gpu.check().unwrap();
            let [width, height] = window_px.map(f64::from);
            let expected = |x: u32, y: u32, channel: usize, encode: &dyn Fn(f64) -> f64| {
                let at = |x: f64, side: u32, of: f64| (x + 0.5) / of * f64::from(side) - 0.5;
                let (px, py) = (at(f64::from(x), SIZE_PX[0], width), at(f64::from(y), SIZE_PX[1], height));
                let (i, j) = (px.floor(), py.floor());
                let (f, g) = (px - i, py - j);
                let load = |dx: i64, dy: i64| exact[inside(i as i64 + dx, j as i64 + dy)][channel];
                let upper = load(0, 0) * (1.0 - f) + load(1, 0) * f;
                let lower = load(0, 1) * (1.0 - f) + load(1, 1) * f;
                encode(upper * (1.0 - g) + lower * g)
            };
            let off = |encode: &dyn Fn(f64) -> f64| {
                let pixels = (0..window_px[1]).flat_map(|y| (0..window_px[0]).map(move |x| (x, y)));
                let channels = pixels.flat_map(|(x, y)| (0..3).map(move |channel| (x, y, channel)));
                channels
                    .filter(|&(x, y, channel)| {
                        let at = (y * window_px[0] + x) as usize * 4 + channel;
                        (f64::from(shown[at]) - expected(x, y, channel, encode)).abs() > 1.6
                    })
                    .count()
            };
            assert_eq!(off(&srgb), 0, "{window_px:?} {format:?}");
            // Planted: colours without encoding.
            assert!(off(&|linear| 255.0 * linear.clamp(0.0, 1.0)) > 1000);
        }
    }
}

#[test]
fn the_window_shows_two_eyes() {
    let Some(bench) = Bench::new() else { return };
    let texels = |seed: i64| -> Vec<[half::f16; 4]> {
        places().map(|(x, y)| std::array::from_fn(|i| half::f16::from_f64(chance(x, y, seed + i as i64)))).collect()
    };
    let both = [texels(0), texels(10)];
    let [left, right] = both.each_ref().map(|texels| bench.picture(&PICTURE, SIZE_PX, &bits(texels)));
    let exact = both.map(|texels| texels.iter().map(|texel| texel.map(half::f16::to_f32)).collect::<Vec<_>>());
    for glasses in [None, Some(Glasses::Coloured), Some(Glasses::Grey)] {
        let width = if glasses.is_none() { 2 * SIZE_PX[0] } else { SIZE_PX[0] };
        let window_px = [width, SIZE_PX[1]];
        let expected = match glasses {
            None => eyes::side_by_side(&exact[0], &exact[1], SIZE_PX[0]),
            Some(glasses) => eyes::anaglyph(&exact[0], &exact[1], glasses),
        };
        let expected = srgb8(&expected);
        let off = |left: &Target, right: &Target| {
            let format = wgpu::TextureFormat::Rgba8Unorm;
            let window = Target::new(
                &bench.gpu,
                &TargetKind::attachment("window", format, Group::Whole.shows("The window")),
                window_px,
            );
            let mut encoder = bench.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let shown = Shown::Pair { left, right, glasses };
            PresentPass::new(&bench.gpu, format).run(&bench.gpu, &mut encoder, shown, &window.view, window_px);
            bench.gpu.queue.submit([encoder.finish()]);
            let drawn = read(&bench.gpu, &window, [0, 0], window_px).unwrap();
            bench.gpu.check().unwrap();
            drawn.iter().zip(&expected).filter(|(drawn, expected)| drawn.abs_diff(**expected) > 1).count()
        };
        assert_eq!(off(&left, &right), 0, "{glasses:?}");
        // Planted: swapped eyes.
        assert!(off(&right, &left) > 1000, "{glasses:?}");
    }
}
