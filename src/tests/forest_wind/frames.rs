//! Frames with leaning trees: both eyes, culling, rest, and the history of temporal anti-aliasing.

use super::*;

#[test]
fn both_eyes_see_trees_lean_alike() {
    let Some(mut world) = wooded(Form::Broadleaf, 60.0, Some(Wind { speed_m_s: 18.0, ..WIND })) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let pose = world.pose("-300,-900,12,340,2,50");
    let clock = Clock { now_s: 71.0, before_s: 70.9 };
    // In the fast tier a strip of the picture.
    let (size_px, least) = if full() { (SIZE_PX, 3000.0) } else { ([80, SIZE_PX[1]], 750.0) };
    let [width, height] = size_px.map(i64::from);
    let rig = Pair { ipd_m: 0.1, convergence_m: None }.rig(&View::whole(pose, pose, size_px).at(clock));
    assert!(rig.eyes.iter().all(|eye| eye.clock == clock));
    let style = Style::load("plain").unwrap();
    let mut same = |rig: &Rig| {
        for _ in 0..2 {
            renderer.render_eyes(&world.gpu, &mut world.surfaces, rig, &style, &north_west()).unwrap();
            world.gpu.wait();
        }
        let [left, right] = [0, 1].map(|eye| {
            let target = |kind| renderer.eye_target(eye, kind).unwrap();
            let ids = read(&world.gpu, target(&SURFACE_ID), [0, 0], size_px).unwrap();
            let ids: Vec<u32> =
                ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
            (ids, places(&world.gpu, &renderer, eye))
        });
        let (mut same, mut all) = (0.0, 0.0);
        for (id, [x, y, z, depth_m]) in left.0.iter().zip(&left.1) {
            let at_m = DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z)) + rig.origin_m;
            let left_m = f64::from(*depth_m);
            let Some(px) = rig.eyes[1].place_px(at_m - rig.eyes[1].pose.position_m) else { continue };
            let [column, row] = [px.x.floor(), px.y.floor()].map(|along| along as i64);
            if *id < id::FIRST_TREE || column < 0 || row < 0 || column >= width || row >= height {
                continue;
            }
            let there = (row * width + column) as usize;
            // A nearer surface hides the tree from the right eye.
            if (1e-6..0.9 * left_m).contains(&f64::from(right.1[there][3])) {
                continue;
            }
            all += 1.0;
            same += f64::from(u8::from(right.0[there] == *id));
        }
        assert!(all > least);
        same / all
    };
    let together = same(&rig);
    // Planted error: an eye whose clock is two seconds later.
    let mut apart = rig.clone();
    apart.eyes[1].clock.now_s += 2.0;
    let later = same(&apart);
    println!("same tree in both eyes: {together:.4}, with one eye two seconds later {later:.4}");
    assert!(together > 0.97 && 1.0 - later > 2.0 * (1.0 - together));
}

/// Tests that a part of a picture has all trees that lean into it from outside.
#[test]
fn what_leans_into_the_picture_is_not_culled() {
    let storm = Wind { speed_m_s: 60.0, from_deg: 250.0 };
    let Some(mut world) = wooded(Form::Conifer, 60.0, Some(storm)) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    world.surfaces.set_tree_detail(4.0);
    // Tall trees, of which only the tops are in the part.
    world.surfaces.set_forest(Some(of(Form::Conifer, 60.0, 40.0)));
    let pose = world.pose("-300,-900,35,340,0,70");
    let clock = Clock::still(9.0);
    let whole = shown(&mut world, &mut renderer, View::whole(pose, pose, SIZE_PX).at(clock));
    let part = Part { origin_px: [140, 0], size_px: [24, 80] };
    let of_part = shown(&mut world, &mut renderer, View::of_part(pose, pose, SIZE_PX, part).at(clock));
    let (mut all, mut other, mut outside) = (0, 0, 0);
    let trees = whole.by_id();
    for y in 0..80_usize {
        for x in 0..24_usize {
            let pixel = y * 320 + 140 + x;
            let Some(tree) = trees.get(&whole.ids[pixel]).filter(|_| whole.position[pixel][3] < 150.0) else {
                continue;
            };
            all += 1;
            other += usize::from(of_part.ids[y * 24 + x] != whole.ids[pixel]);
            // The foot of this tree is outside the part.
            let foot_px = whole.view.place_px(tree.at_m + DVec3::Z * 20.0 - pose.position_m);
            outside += usize::from(foot_px.is_some_and(|px| !(140.0..164.0).contains(&px.x)));
        }
    }
    println!("{other} of {all} pixels differ; {outside} are of trees that lean in");
    // Planted error, by the second bound: without the trees outside, more than half of the pixels would differ.
    assert!(all > 150 && outside > 100 && other * 100 < all);
}

#[test]
fn a_camera_at_rest_in_wind_goes_on_and_one_without_trees_in_view_rests() {
    // The fast tier has fewer trees and a style of fewer passes, and leaves out the calm, in which no tree may sway.
    let (trees_per_ha, style) = if full() { (200.0, "lsa") } else { (20.0, "plain") };
    let Some(mut world) = wooded(Form::Conifer, trees_per_ha, Some(WIND)) else { return };
    let style = Style::load(style).unwrap();
    let (among, sky, above) =
        (world.pose(CAMERA), world.pose("-300,-900,150,15,60,50"), world.pose("0,0,9000,0,-90,40"));
    let mut settles = |pose: Pose, wind: Option<Wind>| {
        world.surfaces.set_wind(wind);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_antialias(Antialias::Temporal);
        let size_px = [96, 54];
        let mut clock = Clock::still(0.0);
        for number in 0..SAMPLES_AT_REST + 4 {
            let view = View::whole(pose, pose, size_px).at(clock);
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
            clock = Clock { now_s: f64::from(number + 1) / 30.0, before_s: clock.now_s };
        }
        let is_due = renderer.is_settling() || renderer.may_sway();
        assert_eq!(
            renderer.is_settling(),
            renderer.may_sway(),
            "sampling must continue exactly as long as trees may sway"
        );
        !is_due
    };
    assert!(!settles(among, Some(WIND)), "the picture rests although trees sway");
    assert!(!full() || settles(among, None), "the picture does not rest without wind");
    assert!(settles(sky, Some(WIND)), "the picture does not rest without trees in view");
    assert!(settles(above, Some(WIND)), "the picture does not rest although canopies do not move");
}

/// Tests that in wind the mean of frames is close to a picture of many samples.
#[test]
fn the_history_follows_trees_that_sway() {
    let Some(mut world) = wooded(Form::Broadleaf, 150.0, Some(WIND)) else { return };
    let style = Style::load("plain").unwrap();
    let pose = world.pose(CAMERA);
    let step_s = 1.0 / 30.0;
    // In the fast tier a strip of the picture.
    let (size_px, count) = (if full() { SIZE_PX } else { [80, SIZE_PX[1]] }, 16_u8);
    let mut flown = |frames: u8, jumps: bool| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_antialias(Antialias::Temporal);
        for number in (0..frames).rev() {
            let now_s = 50.0 - f64::from(number) * step_s;
            // Planted error: trees that were elsewhere in the previous frames, unknown to the motion picture.
            if jumps {
                let elsewhere = Wind { from_deg: WIND.from_deg + 40.0 * f64::from(number), ..WIND };
                world.surfaces.set_wind(Some(elsewhere));
            }
            let view = View::whole(pose, pose, size_px).at(Clock { now_s, before_s: now_s - step_s });
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
        }
        world.surfaces.set_wind(Some(WIND));
        halves(&world.gpu, renderer.target(&PICTURE).unwrap())
    };
    let (followed, lost, alone) = (flown(count, false), flown(count, true), flown(1, false));
    let view = View::whole(pose, pose, size_px).at(Clock::still(50.0));
    let mut truth = vec![[0.0; 4]; followed.len()];
    for sample in 0..count {
        let jitter_px = hachure::picture::supersampling::jitter_px(u32::from(sample) + 1);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &View { jitter_px, ..view }, &style, &north_west());
        for (sum, texel) in truth.iter_mut().zip(halves(&world.gpu, renderer.target(&PICTURE).unwrap())) {
            (0..3).for_each(|i| sum[i] += texel[i] / f64::from(count));
        }
    }
    let off = |picture: &[[f64; 4]]| {
        picture.iter().zip(&truth).map(|(a, b)| (a[1] - b[1]).powi(2)).sum::<f64>() / picture.len() as f64
    };
    let [followed, lost, alone] = [&followed, &lost, &alone].map(|picture| off(picture).sqrt());
    println!("difference from many samples {followed:.5}; without motion of trees {lost:.5}; single frame {alone:.5}");
    assert!(followed < 0.8 * alone && followed < 0.9 * lost);
}
