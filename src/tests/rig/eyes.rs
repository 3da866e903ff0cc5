//! Tests that two eyes in one submit equal the two rendered separately, and that a submit per pass equals a single one.

use hachure::frame::Renderer;
use hachure::gpu::recorder::Submits;
use hachure::scene::view::Rig;
use hachure::style::{self, Style, Tone};

use crate::tests::common::{full, preset};
use crate::tests::rig::{START, differing, draw_rig, few_presets, hill, seen, shifted_right, view};

/// Returns a short flight of two eyes, half a metre to either side of its path.
fn rigs(world: &crate::tests::rig::World) -> Vec<Rig> {
    let start = world.pose(START);
    let mut previous = start;
    let mut step = |i: u32| {
        let mut pose = start;
        pose.position_m += start.forward * (0.8 * f64::from(i)) + start.right * (0.1 * f64::from(i));
        let before = std::mem::replace(&mut previous, pose);
        let eyes = [-0.5, 0.5].map(|side_m| view(shifted_right(before, side_m), shifted_right(pose, side_m)));
        Rig { origin_m: pose.position_m, eyes: eyes.to_vec() }
    };
    (0..if full() { 3 } else { 2 }).map(&mut step).collect()
}

/// Returns a preset whose eyes are independent in lines and marks, with masses that are not edited and a sky that
/// is not composed, as in a pair, and without strokes, which always agree in a pair.
fn alone(name: &str) -> Style {
    let mut style = preset(name);
    if let Some(lines) = style.lines_mut() {
        lines.stereo = style::Stereo::Alone;
    }
    if let Some(hatching) = style.hatching_mut() {
        hatching.balance = false;
    }
    style.set_strokes(None);
    if let Tone::Toon(toon) = &mut style.tone {
        toon.smallest_share = 0.0;
    }
    // A single eye has clouds and a sun that are composed for its frame; a pair cannot.
    (style.sky.clouds, style.sky.sun_deg) = (0.0, 0.0);
    style
}

#[test]
fn two_eyes_at_once_are_the_two_alone() {
    let Some(mut world) = hill() else { return };
    for name in few_presets() {
        let style = alone(name);
        let rigs = rigs(&world);
        // The frame is one submit, as on a GPU.
        let mut both = Renderer::new(&world.gpu).unwrap();
        let mut alone = [0, 1].map(|_| Renderer::new(&world.gpu).unwrap());
        for rig in &rigs {
            draw_rig(&mut world, &mut both, &style, rig);
            let pair = [0, 1].map(|eye| seen(&world, &both, eye));
            for (eye, (renderer, together)) in alone.iter_mut().zip(&pair).enumerate() {
                // The eye's own rig has the same origin, so it uses the same tiles.
                let own = Rig { origin_m: rig.origin_m, eyes: vec![rig.eyes[eye]] };
                draw_rig(&mut world, renderer, &style, &own);
                let differing = differing(together, &seen(&world, renderer, 0));
                assert_eq!(differing, 0, "{name}: eye {eye} sees a different picture in a pair");
            }
            // Control: the eyes differ.
            assert!(differing(&pair[0], &pair[1]) > 1000, "{name}");
        }
    }
}

#[test]
fn a_rig_is_prepared_for_the_pixels_of_all_its_eyes() {
    let Some(world) = hill() else { return };
    let pixels = f64::from(crate::tests::rig::SIZE_PX[0] * crate::tests::rig::SIZE_PX[1]);
    for rig in rigs(&world) {
        let asked = hachure::frame::terrain_view_of(&rig, 0.0);
        assert!((asked.pixels - 2.0 * pixels).abs() < 1e-9 && asked.frusta.len() == 2);
        let one = hachure::frame::terrain_view_of(&Rig { eyes: vec![rig.eyes[0]], ..rig }, 0.0);
        assert!((one.pixels - pixels).abs() < 1e-9 && one.frusta.len() == 1);
    }
}

#[test]
fn one_submit_draws_what_many_draw() {
    let Some(mut world) = hill() else { return };
    for name in few_presets() {
        let style = preset(name);
        let drawn = [Submits::Timed, Submits::Whole].map(|submits| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            renderer.set_submits(submits);
            let mut pictures = Vec::new();
            for rig in rigs(&world) {
                draw_rig(&mut world, &mut renderer, &style, &rig);
                pictures.push([0, 1].map(|eye| seen(&world, &renderer, eye)));
            }
            pictures
        });
        let [passes, whole] = drawn;
        for (passes, whole) in passes.iter().flatten().zip(whole.iter().flatten()) {
            assert_eq!(differing(passes, whole), 0, "{name}");
        }
        // Planted: another frame.
        assert!(differing(&passes[0][0], &whole[whole.len() - 1][0]) > 1000, "{name}");
    }
}

#[test]
fn an_eye_away_from_the_origin_sees_what_one_at_the_origin_sees() {
    let Some(mut world) = hill() else { return };
    let pose = world.pose(START);
    let names = if full() { vec!["plain", "lsa", "pen", "hachures", "wash"] } else { vec!["lsa", "wash"] };
    for name in names {
        let style = preset(name);
        let mut drawn = |origin_m: glam::DVec3, shown: glam::DVec3| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            let mut shown_pose = pose;
            shown_pose.position_m = shown;
            let rig = Rig { origin_m, eyes: vec![view(shown_pose, shown_pose)] };
            draw_rig(&mut world, &mut renderer, &style, &rig);
            crate::tests::rig::luma(&world, &renderer)
        };
        let here = pose.position_m;
        let away = here - pose.right * 3.0 + pose.up * 2.0;
        let (at, displaced) = (drawn(here, here), drawn(away, here));
        // Positions are relative to another origin, so level of detail and rounding differ.
        let differs = crate::tests::rig::differs(&at, &displaced);
        // Planted: an eye at the other origin.
        let elsewhere = crate::tests::rig::differs(&at, &drawn(away, away));
        println!("{name}: {differs:.4} of the pixels differ, {elsewhere:.4} from elsewhere");
        assert!(differs < 0.03 && elsewhere > 1.5 * differs, "{name}: {differs} {elsewhere}");
    }
}
