//! Lines, strokes and marks of two eyes are the same.

use hachure::measure::stereo::orphans;
use hachure::picture::nearest::nearest_m;
use hachure::style::Style;

use super::*;
use crate::common::World;

const MOUNTAINS: [(&str, &str, &str); 3] = [
    ("Rainier", "dem/geotiff/mt_rainier_90m.tif", "-19800,30500,+500,0,3,50"),
    ("Everest", "dem/geotiff/mt_everest_90m.tif", "0,-15000,+900,0,2,50"),
    ("Alps", "dem/geotiff/N46E008_alps.tif", "0,0,+300,40,0,55"),
];

#[test]
#[ignore = "a picture to look at"]
fn orphan_map() {
    for (place, file, camera) in MOUNTAINS {
        let Some(mut world) = World::real(file, 1.0) else { return };
        let pose = world.pose(camera);
        let style = Style::load(&std::env::var("STYLE").unwrap_or("ink".into())).unwrap();
        let mut frame = Frame::new(&world.gpu).unwrap();
        let nearest = nearest_m(&world.gpu, &mut frame, &mut world.surfaces, pose, &style).unwrap().unwrap();
        let rig = rig(pose, nearest / 30.0);
        let eyes = draw(&world.gpu, &mut world.surfaces, &style, &rig);
        println!("{place}: nearest {nearest:.1} m, {:?}", agreement(&eyes));
        let mut bytes = Vec::new();
        for (own, other) in [(0, 1), (1, 0)] {
            let lacking = orphans(&eyes[own], &eyes[other]).unwrap();
            for (ink, lacking) in eyes[own].ink.as_ref().unwrap().iter().zip(lacking) {
                let g = (255.0 * (1.0 - ink)) as u8;
                let red = lacking > 0.2 * ink.max(0.3);
                bytes.extend(if red { [255, 0, 0, 255] } else { [g, g, g, 255] });
            }
        }
        let path = std::path::PathBuf::from(format!("/work/t/st/orphans-{place}.png"));
        let mut png = hachure::file::png::PngWriter::create(&path, SIZE_PX[0], 2 * SIZE_PX[1]).unwrap();
        png.write_rows(&bytes).unwrap();
        png.finish().unwrap();
    }
}

#[test]
#[ignore = "debugging"]
fn which_samples() {
    for (place, file, camera) in MOUNTAINS {
        let Some(mut world) = World::real(file, 1.0) else { return };
        let pose = world.pose(camera);
        let style = Style::load(&std::env::var("STYLE").unwrap_or("strokes".into())).unwrap();
        let mut frame = Frame::new(&world.gpu).unwrap();
        let nearest = nearest_m(&world.gpu, &mut frame, &mut world.surfaces, pose, &style).unwrap().unwrap();
        let rig = rig(pose, nearest / 30.0);
        let mut frame = Frame::new(&world.gpu).unwrap();
        let prepared = frame::prepare(&world.gpu, &mut world.surfaces, &rig, &style, &light());
        frame.render_rig(&world.gpu, &world.surfaces, &prepared, &rig, &style, &light()).unwrap();
        let lists: Vec<_> =
            [0, 1].map(|eye| frame.eye_strokes(eye).unwrap().samples().read(&world.gpu).unwrap()).into();
        for (own, other) in [(1usize, 0usize), (0, 1)] {
            let (mut all, mut none, mut same, mut differ, mut low) = (0, 0, 0, 0, 0);
            let ids: std::collections::HashSet<u32> = lists[other].1.iter().map(|s| s.stroke).collect();
            let mut known = 0;
            let view = &rig.eyes[other];
            for s in &lists[own].1[..lists[own].0.fresh as usize] {
                if s.pressure < 0.1 {
                    low += 1;
                    continue;
                }
                all += 1;
                known += i32::from(ids.contains(&s.stroke));
                let at = DVec3::new(s.position_m[0].into(), s.position_m[1].into(), s.position_m[2].into())
                    + rig.origin_m
                    - view.pose.position_m;
                let Some(px) = view.place_px(at) else { continue };
                let near: Vec<_> = lists[other]
                    .1
                    .iter()
                    .filter(|o| ((o.px[0] as f64 - px.x).powi(2) + (o.px[1] as f64 - px.y).powi(2)).sqrt() < 2.5)
                    .collect();
                if near.is_empty() {
                    none += 1
                } else if near.iter().any(|o| o.stroke == s.stroke) {
                    same += 1
                } else {
                    differ += 1
                }
            }
            println!(
                "{place} eye {own}: {all} drawn, {low} low, none {none}, same {same}, differ {differ}; known ids {known}"
            );
        }
    }
}
