//! Measures what hatching costs, relative to the toon pass of the same picture and to fewer directions: ratios within
//! one run. `cargo bench --bench hatching` prints them. The target on a software driver is at most 2.5 for one
//! direction against toon, and 2.0 for three directions against one.
#![allow(clippy::unwrap_used, reason = "a measurement may panic")]

#[path = "../src/tests/common/mod.rs"]
mod common;

use glam::DVec3;
use hachure::frame::Light;
use hachure::picture::{self, PartRule, PictureRequest};
use hachure::style::Style;

use common::World;
use common::hill::Hill;

/// Pictures of each style. Other work on the machine can only add to a time, so the minimum of more pictures is closer
/// to the truth.
const ROUNDS: usize = 20;

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

/// Returns the shortest times of the toon pass and of the hatching passes for each style, in milliseconds. The styles
/// take turns.
fn times_ms(world: &mut World, styles: &[Style]) -> Vec<(f64, f64)> {
    let pose = world.pose("-500,-700,420,35,-22,50");
    let light = Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), haze_m: 1e6, haze_srgb: None, focus: None };
    let mut frames: Vec<_> = styles.iter().map(|_| None).collect();
    let mut times = vec![(f64::INFINITY, f64::INFINITY); styles.len()];
    for _ in 0..ROUNDS {
        for ((style, frame), least) in styles.iter().zip(&mut frames).zip(&mut times) {
            let request = PictureRequest::still(pose, [640, 360], style, light);
            let take = |_| Ok::<_, std::convert::Infallible>(());
            let parts = PartRule::default();
            let report =
                picture::render_in_parts(&world.gpu, frame, &mut world.surfaces, &request, &parts, take).unwrap();
            let sum_ms = |of: &[&str]| {
                let named = report.passes.iter().filter(|pass| of.iter().any(|name| pass.name.starts_with(name)));
                named.map(|pass| pass.gpu_ms).sum::<f64>()
            };
            least.0 = least.0.min(sum_ms(&["tones/toon"]));
            least.1 = least.1.min(sum_ms(&["tones/hatching", "tones/balance"]));
        }
    }
    times
}

fn main() {
    let (_, grid) = Hill::square(257, 12.0);
    let Some(mut world) = World::new(grid, 1.0) else { return };
    let all = ["slope", "contour", "fixed", "sight"].map(layer);
    let times = times_ms(&mut world, &[style(&all[0]), style(&all[..3].concat()), style(&all.concat())]);
    let [(toon, one), (_, three), (_, four)] = times[..] else { panic!("three styles have three times") };
    println!(
        "toon {toon:.1} ms, hatching {one:.1} ms ({:.2} ×), three directions {:.2} × that, four {:.2} ×",
        one / toon,
        three / one,
        four / one
    );
}
