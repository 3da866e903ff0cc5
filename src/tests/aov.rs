//! The channel `hatch` has the ink of every layer that makes tone: hatching, rows of hachures, and cut lines.

use crate::tests::common;

use common::World;
use common::draw::north_west;
use common::hill::Hill;
use hachure::file::exr::Samples;
use hachure::picture::{self, Band, PartRule, PictureRequest, aov};
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [320, 180];

/// Returns the brightness of the picture and its channel `hatch`, row by row.
fn drawn(world: &mut World, style: &Style) -> (Vec<f32>, Vec<f32>) {
    let planes = aov::planes("hatch", style).unwrap();
    let pose = world.pose("0,-1400,+250,0,-8,50");
    let request = PictureRequest { planes: &planes, ..PictureRequest::still(pose, SIZE_PX, style, north_west()) };
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
        assert!(chosen.len() > 200, "only {} pixels", chosen.len());
        chosen.iter().sum::<f32>() / chosen.len() as f32
    };
    mean(&|hatch| hatch < 0.3) / mean(&|hatch| hatch > 0.98)
}

#[test]
fn hatch_has_every_mark_that_makes_tone() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    for name in ["crosshatch", "hachures", "engraving"] {
        let style = common::absolute(name).without(&["water"]);
        let (brightness, hatch) = drawn(&mut world, &style);
        let ratio = contrast(&brightness, &hatch);
        assert!(ratio < 0.5, "{name}: pixels under marks are {ratio} times as bright as bare ones");
        // Planted error: the marks of another place.
        let mut elsewhere = hatch.clone();
        elsewhere.rotate_right(SIZE_PX[0] as usize * 7 + 5);
        let ratio = contrast(&brightness, &elsewhere);
        assert!(ratio > 0.5, "{name}: marks of another place pass with {ratio}");
        // Planted error: a style without marks that make tone has none in the channel.
        let bare = style.without(&["hatching", "rows", "cuts"]);
        let (_, hatch) = drawn(&mut world, &bare);
        assert!(hatch.iter().filter(|hatch| **hatch < 0.3).count() < 200, "{name}: marks without a layer of marks");
    }
}
