//! Tests lines from shading on land: rough land has some, flat land has none, and parts of a picture equal the whole.

use super::*;

/// Returns the ink of dark lines and of highlight lines in a picture of a world, in pixels.
fn ink_of_world(world: &mut World, camera: &str, style: &Style, light: &Light) -> [f64; 2] {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, [320, 200]), style, light);
    assert!(
        draw::halves(&world.gpu, renderer.target(&PICTURE).unwrap()).iter().flatten().all(|value| value.is_finite())
    );
    let ink = draw::halves(&world.gpu, renderer.target(&ink::TONE_INK).unwrap());
    [DARK, LIGHT].map(|kind| ink.iter().map(|ink| ink[kind]).sum())
}

#[test]
fn land_has_lines_and_flat_ground_and_no_light_have_none() {
    let Some(mut rough) = World::new(grid_of(513, 513, 60.0, rough_height_m), 1.0) else { return };
    let style = Style::load("tone-lines").unwrap();
    let camera = "0,-9000,+2500,0,-14,55";
    for light in ["head", "sun", "side"].into_iter().take(if common::full() { 3 } else { 1 }) {
        let text = style.text().replace("light = \"head\"", &format!("light = \"{light}\""));
        let style = Style::parse("t", &text).unwrap();
        let [dark, bright] = ink_of_world(&mut rough, camera, &style, &north_west());
        println!("rough land, light {light}: {dark:.0} px of dark lines, {bright:.0} of highlights");
        assert!(dark > 100.0 && bright > 20.0);
    }
    // The sun behind the land, and a sun that lights no part of it.
    let sun = Style::parse(
        "t",
        &style.text().replace("light = \"head\"", "light = \"sun\"").replace("skyline = true", "skyline = false"),
    )
    .unwrap();
    for (to_sun, wrap, is_calm) in [(DVec3::new(0.0, 0.95, 0.3), 0.2, false), (-DVec3::Z, 0.0, true)] {
        let mut style = sun.clone();
        style.light.wrap = wrap;
        let ink = ink_of_world(&mut rough, camera, &style, &Light { to_sun: to_sun.normalize(), ..NOON });
        assert!(!is_calm || ink == [0.0; 2], "{to_sun}: {ink:?}");
    }
    let Some(mut flat) = World::new(grid_of(257, 257, 30.0, |_, _| 100.0), 1.0) else { return };
    for camera in ["0,0,2000,0,-90,50", "0,-2000,+600,0,-40,40"] {
        let ink = ink_of_world(&mut flat, camera, &sun, &north_west());
        assert!(ink[DARK] < 1.0 && ink[LIGHT] < 1.0, "{camera}: {ink:?}");
    }
}

#[test]
fn parts_of_a_large_picture_have_the_lines_of_the_whole() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let mut style = Style::load("tone-lines").unwrap();
    style.set_water(None);
    style.paper.grain = 0.0;
    // A shot reads the errors of LSA, so the style needs its lines.
    style.set_lines(Style::load("lsa").unwrap().lines().cloned());
    style.lines_mut().unwrap().crowd = 1.0;
    let pose = world.pose("900,-900,+20,315,3,60");
    let mut renderer = None;
    let size_px = if common::full() { [320, 200] } else { [160, 100] };
    let mut shoot = |style: &Style, rule: PartRule| {
        common::shot::shoot_style(&mut world, &mut renderer, pose, pose, size_px, style, &rule).picture
    };
    let whole = shoot(&style, PartRule::default());
    let parts = PartRule { whole_px: 1, part_px: 64, margin_px: 12 };
    let differing = |parts: Vec<[f32; 4]>| {
        let apart = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.02);
        whole.iter().zip(&parts).filter(|pair| apart(*pair)).count()
    };
    let own = differing(shoot(&style, parts));
    println!("{own} of {} pixels differ where parts meet", whole.len());
    assert!(own < whole.len() / 3200);
    // Planted: slightly wider lines.
    style.tone_lines_mut().unwrap().width_px += 0.3;
    assert!(differing(shoot(&style, parts)) > whole.len() / 640);
}
