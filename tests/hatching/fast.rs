//! What hatching costs, against the toon pass of the same picture and against fewer directions: ratios within one run.

use glam::DVec3;
use hachure::frame::Light;
use hachure::picture::{self, PartRule, PictureRequest};
use hachure::style::Style;

use crate::common::World;
use crate::common::hill::Hill;

/// Hatching against toon, at most.
const ALLOWED: f64 = 2.5;
/// Three directions against one: twice is the goal, and machines are noisy.
const ALLOWED_THREE: f64 = 2.6;

fn style(layers: &str) -> Style {
    let text = format!(
        "name = \"lit\"\ndescription = \"\"\n[light]\nshadow = 1.0\nocclusion = 1.0\n[tone]\nkind = \"toon\"\n\
         steps = 0\ndarkest = 0.05\nlightest = 0.9\nwash = 0.0\n[hatching]\n{layers}"
    );
    Style::parse("lit", &text).unwrap()
}

fn layer(direction: &str) -> String {
    format!("[[hatching.layers]]\nmarks = \"line\"\ndirection = \"{direction}\"\n")
}

/// Median milliseconds of the toon and of the hatching pass.
fn times_ms(world: &mut World, style: &Style) -> (f64, f64) {
    let pose = world.pose("-500,-700,420,35,-22,50");
    let light = Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), haze_m: 1e6, haze_srgb: None };
    let mut frame = None;
    let (mut toon, mut hatching) = (Vec::new(), Vec::new());
    for _ in 0..9 {
        let request = PictureRequest::still(pose, [640, 360], style, light);
        let take = |_| Ok::<_, std::convert::Infallible>(());
        let report =
            picture::render_in_parts(&world.gpu, &mut frame, &mut world.terrain, &request, &PartRule::default(), take)
                .unwrap();
        let of = |name: &str| report.passes.iter().find(|pass| pass.name == name).map(|pass| pass.gpu_ms);
        toon.extend(of("tones/toon"));
        hatching.extend(of("tones/hatching"));
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    };
    (median(&mut toon), median(&mut hatching))
}

#[test]
fn hatching_costs_little_more_than_toon() {
    let (_, grid) = Hill::square(257, 12.0);
    let Some(mut world) = World::new(grid, 1.0) else { return };
    let (toon, one) = times_ms(&mut world, &style(&layer("slope")));
    let three = ["slope", "contour", "fixed"].map(layer).concat();
    let (_, three) = times_ms(&mut world, &style(&three));
    println!(
        "toon {toon:.1} ms, hatching {one:.1} ms ({:.2} ×), three directions {:.2} × that",
        one / toon,
        three / one
    );
    assert!(one <= ALLOWED * toon, "{one} ms and {toon} ms");
    assert!(three <= ALLOWED_THREE * one, "{three} ms and {one} ms");
    // Four layers of it are too slow: the ratio can say no.
    let four = ["slope", "contour", "fixed", "sight"].map(layer).concat();
    let (toon, four) = times_ms(&mut world, &style(&four));
    assert!(four > ALLOWED * toon, "{four} ms and {toon} ms");
}
