//! The channel `hatch` has the ink of every layer that makes tone: hatching, rows of hachures, and cut lines.

use crate::tests::common;

use common::draw::north_west;
use common::hill::Hill;
use common::{World, full};
use hachure::file::exr::Samples;
use hachure::picture::{self, Band, PartRule, PictureRequest, aov};
use hachure::style::Style;

fn size_px() -> [u32; 2] {
    if full() { [320, 180] } else { [160, 90] }
}

/// Returns the number of pixels that are a visible part of a picture.
fn least_px() -> usize {
    if full() { 200 } else { 50 }
}

/// Returns the brightness of the picture and its channel `hatch`, row by row.
fn drawn(world: &mut World, style: &Style) -> (Vec<f32>, Vec<f32>) {
    let planes = aov::planes("hatch", style).unwrap();
    let pose = world.pose("0,-1400,+250,0,-8,50");
    let request = PictureRequest { planes: &planes, ..PictureRequest::still(pose, size_px(), style, north_west()) };
    let (mut brightness, mut hatch) = (Vec::new(), Vec::new());
    let take = |band: Band| {
        brightness.extend(band.picture.iter().map(|texel| texel[1]));
        for samples in band.planes {
            if let Samples::F32(values) = samples {
                hatch.extend(values);
            }
        }
        Ok::<_, std::convert::Infallible>(())
    };
    let rule = PartRule::default();
    picture::render_in_parts(&world.gpu, &mut None, &mut world.surfaces, &request, &rule, take).unwrap();
    (brightness, hatch)
}

/// Returns the mean brightness where marks cover the pixel, as a fraction of that where there are none.
fn contrast(brightness: &[f32], hatch: &[f32]) -> f32 {
    let mean = |is_wanted: &dyn Fn(f32) -> bool| {
        let chosen: Vec<f32> =
            brightness.iter().zip(hatch).filter(|(_, hatch)| is_wanted(**hatch)).map(|(bright, _)| *bright).collect();
        assert!(chosen.len() > least_px(), "only {} pixels", chosen.len());
        chosen.iter().sum::<f32>() / chosen.len() as f32
    };
    mean(&|hatch| hatch < 0.3) / mean(&|hatch| hatch > 0.98)
}

#[test]
fn hatch_has_every_mark_that_makes_tone() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    for name in ["crosshatch", "hachures", "engraving"] {
        let style = common::preset(name).without(&["water"]);
        let (brightness, hatch) = drawn(&mut world, &style);
        let ratio = contrast(&brightness, &hatch);
        assert!(ratio < 0.5, "{name}: pixels under marks are {ratio} times as bright as bare ones");
        // Planted error: the marks of another place.
        let mut elsewhere = hatch.clone();
        elsewhere.rotate_right(size_px()[0] as usize * 7 + 5);
        let ratio = contrast(&brightness, &elsewhere);
        assert!(ratio > 0.5, "{name}: marks of another place pass with {ratio}");
        // Planted error: a style without marks that make tone has none in the channel.
        if !full() && name != "crosshatch" {
            continue;
        }
        let bare = style.without(&["hatching", "rows", "cuts"]);
        let (_, hatch) = drawn(&mut world, &bare);
        let marked = hatch.iter().filter(|hatch| **hatch < 0.3).count();
        assert!(marked < least_px(), "{name}: marks without a layer of marks");
    }
}
