//! Tests that a picture rendered in parts equals the picture rendered as a whole, including lines and paper, at any
//! size.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::shot::{Shot, ink, shoot_style};
use common::{World, grid_of, rough_height_m};
use glam::DVec3;
use hachure::picture::PartRule;
use hachure::style::Style;

const WHOLE: PartRule = PartRule { whole_px: u64::MAX, part_px: 2048, margin_px: 12 };
const VIEW: &str = "-300,-2500,+350,20,-14,60";

/// Differences between two pictures of the same view.
#[derive(Debug)]
struct Difference {
    /// Pixels whose colour differs by more than 1/64 in any channel.
    pixels: usize,
    /// The largest difference of a colour's channel.
    worst: f32,
    /// Pixels where E(p) differs by more than 0.02.
    errors: usize,
    /// Pixels that are sky in one and surface in the other.
    sky: usize,
    count: usize,
}

fn difference(whole: &Shot, parts: &Shot) -> Difference {
    assert_eq!(whole.picture.len(), parts.picture.len());
    let mut found = Difference { pixels: 0, worst: 0.0, errors: 0, sky: 0, count: whole.picture.len() };
    for (pixel, (a, b)) in whole.picture.iter().zip(&parts.picture).enumerate() {
        let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        found.worst = found.worst.max(off);
        found.pixels += usize::from(off > 1.0 / 64.0);
        found.errors += usize::from((whole.error[pixel] - parts.error[pixel]).abs() > 0.02);
        found.sky += usize::from(whole.is_sky(pixel) != parts.is_sky(pixel));
    }
    found
}

impl Difference {
    /// Returns whether at most one pixel in 2,000 differs. Some may fall on the other side of an edge, because rounding
    /// of rays differs in parts.
    fn holds(&self) -> bool {
        let outliers = self.count / 2000;
        self.pixels <= outliers && self.errors <= outliers && self.sky <= outliers
    }
}

fn world() -> Option<World> {
    World::new(grid_of(401, 401, 20.0, rough_height_m), 1.0)
}

fn render(world: &mut World, size_px: [u32; 2], parts: &PartRule) -> Shot {
    render_style(world, size_px, &ink("footprint"), parts)
}

fn render_style(world: &mut World, size_px: [u32; 2], style: &Style, parts: &PartRule) -> Shot {
    let pose = world.pose(VIEW);
    let mut previous = pose;
    previous.position_m -= DVec3::new(3.0, 1.0, 0.5);
    shoot_style(world, &mut None, pose, previous, size_px, style, parts)
}

#[test]
fn parts_join_without_a_seam() {
    let Some(mut world) = world() else { return };
    let cases: &[([u32; 2], u32)] = if common::full() {
        &[([317, 211], 100), ([320, 180], 64), ([129, 257], 128), ([1, 500], 90)]
    } else {
        &[([159, 105], 80)]
    };
    for &(size_px, part_px) in cases {
        let whole = render(&mut world, size_px, &WHOLE);
        let parts = render(&mut world, size_px, &PartRule { whole_px: 0, part_px, margin_px: 12 });
        assert_eq!(whole.report.parts, 1);
        assert!(parts.report.parts > 1, "{size_px:?} in parts of {part_px}");
        let found = difference(&whole, &parts);
        println!("{size_px:?} in {} parts of {part_px} px: {found:?}", parts.report.parts);
        assert!(found.holds(), "{size_px:?} in parts of {part_px} px: {found:?}");
        if size_px[0] > 100 {
            // A cap of crowded lines would add its own margin.
            let mut open = ink("footprint");
            open.lines_mut().unwrap().crowd = 1.0;
            let rules = [WHOLE, PartRule { whole_px: 0, part_px, margin_px: 0 }];
            let [whole, bare] = rules.map(|parts| render_style(&mut world, size_px, &open, &parts));
            let found = difference(&whole, &bare);
            println!("without margins: {found:?}");
            assert!(!found.holds(), "the seams of parts without margins were not detected");
        }
    }
}

#[test]
fn marks_join_without_a_seam() {
    let Some(mut world) = world() else { return };
    // Marks are balanced with those around them. Large marks need a larger margin, and so does the curvature of a
    // coarse form.
    let cases = [
        ("blend", 1.0, "slope", 12.0),
        ("blend", 3.0, "slope", 12.0),
        ("add", 1.0, "slope", 12.0),
        ("blend", 1.0, "curvature", 48.0),
    ];
    // In the fast tier small pictures, and without the first case, which the second one includes.
    let (size_px, part_px) = if common::full() { ([317, 211], 100) } else { ([127, 95], 64) };
    for (scale, size, direction, form_px) in cases.into_iter().skip(usize::from(!common::full())) {
        let text = format!(
            "name = \"marks\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0.1\n\
             lightest = 0.9\nwash = 0.0\n[hatching]\nscale = \"{scale}\"\nform_px = {form_px:?}\n[[hatching.layers]]\nmarks = \"line\"\ndirection = \"{direction}\"\nsize = {size:?}\n"
        );
        let hatched = Style::parse("marks", &text).unwrap();
        let mut style = Style { tone: hatched.tone.clone(), ..ink("footprint") };
        style.set_hatching(hatched.hatching().cloned());
        let rule = PartRule { whole_px: 0, part_px, margin_px: 12 };
        let whole = render_style(&mut world, size_px, &style, &WHOLE);
        let parts = render_style(&mut world, size_px, &style, &rule);
        assert!(parts.report.parts > 1);
        let found = difference(&whole, &parts);
        println!("{scale}, marks of size {size} by {direction}: {found:?}");
        assert!(found.holds(), "{scale}, marks of size {size}: {found:?}");
        style.hatching_mut().unwrap().balance = false;
        let bare = difference(&whole, &render_style(&mut world, size_px, &style, &rule));
        assert!(!bare.holds(), "marks without balance were not detected: {bare:?}");
    }
}

#[test]
fn odd_sizes_are_pictures() {
    let Some(mut world) = world() else { return };
    let sizes_px: &[[u32; 2]] = if common::full() {
        &[[1, 1], [3, 2], [1, 500], [500, 1], [7, 9], [255, 257]]
    } else {
        &[[1, 1], [1, 90], [90, 1], [63, 65]]
    };
    for &size_px in sizes_px {
        let shot = render(&mut world, size_px, &PartRule::default());
        let pixels = size_px[0] as usize * size_px[1] as usize;
        assert_eq!((shot.picture.len(), shot.depth_m.len(), shot.line.len()), (pixels, pixels, pixels));
        assert!(shot.picture.iter().flatten().all(|value| value.is_finite() && (0.0..=1.001).contains(value)));
        assert!(shot.line.iter().chain(&shot.tone).all(|value| (0.0..=1.0).contains(value)));
        assert!(shot.motion_px.iter().all(|motion| motion.is_finite()), "{size_px:?}");
        println!(
            "{size_px:?}: {} sky, {} lines",
            shot.depth_m.iter().filter(|depth| depth.is_infinite()).count(),
            shot.line.iter().filter(|line| **line > 0.5).count()
        );
    }
}
