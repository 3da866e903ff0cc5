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
        let lacking = orphans(&eyes[0], &eyes[1]).unwrap();
        let ink = eyes[0].ink.as_ref().unwrap();
        let other = eyes[1].ink.as_ref().unwrap();
        let mut bytes = Vec::new();
        for i in 0..ink.len() {
            let g = (255.0 * (1.0 - ink[i])) as u8;
            let l = lacking[i];
            if l > 0.05 { bytes.extend([255, 0, 0, 255]) } else { bytes.extend([g, g, g, 255]) }
        }
        for v in other { let g = (255.0 * (1.0 - v)) as u8; bytes.extend([g, g, g, 255]) }
        let path = std::path::PathBuf::from(format!("/work/t/st/orphans-{place}.png"));
        let mut png = hachure::file::png::PngWriter::create(&path, SIZE_PX[0], 2 * SIZE_PX[1]).unwrap();
        png.write_rows(&bytes).unwrap();
        png.finish().unwrap();
    }
}
