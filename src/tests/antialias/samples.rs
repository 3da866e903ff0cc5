//! A picture with several samples per pixel equals a much larger picture scaled down; its channels (AOVs) do not
//! change.

use hachure::file::exr::Samples;
use hachure::picture::{Band, PictureRequest, aov, render};
use hachure::style::Style;

use crate::tests::common::draw::north_west;
use crate::tests::common::{World, full};

const SIZE_PX: [u32; 2] = [96, 54];

/// Returns a style of flat colours without lines, whose content does not depend on the size of the picture.
fn plain() -> Style {
    let mut style = Style::load("plain").unwrap();
    style.paper.grain = 0.0;
    style
}

fn shoot(world: &mut World, style: &Style, size_px: [u32; 2], samples: u32) -> Band {
    let pose = world.pose(crate::tests::antialias::VIEW);
    let planes = aov::planes("depth,normal", style).unwrap();
    let still = PictureRequest::still(pose, size_px, style, north_west());
    let request = PictureRequest { planes: &planes, samples, ..still };
    let mut bands = Vec::new();
    let take = |band| {
        bands.push(band);
        Ok::<_, ()>(())
    };
    render(&world.gpu, &mut None, &mut world.surfaces, &request, take).unwrap();
    world.gpu.check().unwrap();
    bands.pop().unwrap()
}

/// Scales the picture down: each pixel is the mean of `side` × `side` pixels.
fn shrunk(picture: &[[f32; 4]], side: usize) -> Vec<[f32; 4]> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mean = |x: usize, y: usize, channel: usize| {
        let of = (0..side * side).map(|i| picture[(y * side + i / side) * width * side + x * side + i % side][channel]);
        of.sum::<f32>() / (side * side) as f32
    };
    (0..width * height).map(|pixel| std::array::from_fn(|i| mean(pixel % width, pixel / width, i))).collect()
}

/// Returns the root mean square difference.
fn apart(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let squared: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from((a - b).powi(2))).sum();
    (squared / (4 * a.len()) as f64).sqrt()
}

#[test]
fn samples_are_a_larger_picture_made_small() {
    let Some(mut world) = crate::tests::antialias::fine_rough() else { return };
    let style = plain();
    let truth = shrunk(&shoot(&mut world, &style, SIZE_PX.map(|side| 6 * side), 1).picture, 6);
    let counts = [1, 4, 16, 64].into_iter().take(if full() { 4 } else { 3 });
    let off: Vec<f64> =
        counts.map(|samples| apart(&shoot(&mut world, &style, SIZE_PX, samples).picture, &truth)).collect();
    println!("1, 4, 16 (and 64) samples differ from the mean of 36 pixels by {off:.5?}");
    assert!(off[1] < 0.75 * off[0] && off[2] < 0.35 * off[0], "{off:?}");
    assert!(off.get(3).is_none_or(|most| *most < 0.7 * off[2]), "{off:?}");
    // Planted error: a larger picture that is shifted by a pixel.
    let mut moved = truth.clone();
    moved.rotate_right(1);
    assert!(apart(&moved, &truth) > 2.0 * off[2]);
}

#[test]
fn lines_converge_and_channels_stay() {
    let Some(mut world) = crate::tests::antialias::rough() else { return };
    let (styles, counts) = if full() { (2, [1, 8, 32, 64]) } else { (1, [1, 5, 9, 10]) };
    for name in ["lsa", "pen"].into_iter().take(styles) {
        let style = Style::load(name).unwrap();
        let [one, few, more, most] = counts.map(|samples| shoot(&mut world, &style, SIZE_PX, samples));
        let off = [&one, &few, &more].map(|band| apart(&band.picture, &most.picture));
        println!("{name}: of {counts:?} samples, the first three differ from the last by {off:.5?}");
        assert!(off[1] < 0.5 * off[0] && off[2] < 0.6 * off[1], "{name}: {off:?}");
        let bits = |band: &Band| -> Vec<u32> {
            let of = |samples: &Samples| match samples {
                Samples::F32(values) => values.iter().map(|value| value.to_bits()).collect::<Vec<_>>(),
                Samples::U32(values) => values.clone(),
            };
            band.planes.iter().flat_map(of).collect()
        };
        assert!(bits(&one) == bits(&most), "{name}: the channels depend on the number of samples");
    }
}
