//! Tests that a written file, when rasterised, shows the ink of its frame.

use std::process::Command;

use hachure::file::svg::write_svg;
use hachure::vector::sheet::Sheet;
use hachure::vector::{groups, layers};
use kurbo::{ParamCurve, Point, Shape};

use super::{HILL, RAINIER, Read, SIZE_PX, drawing, hill, read, settings, strokes_of, written};
use crate::tests::common::{World, full};

/// Rasterises paths with the pen of the shader: coverage depends on the distance from the middle, and the darker ink
/// stays.
fn rasterised(paths: &[Read]) -> Vec<f32> {
    rasterised_at(paths, SIZE_PX)
}

/// Does the same on a page of another size.
pub fn rasterised_at(paths: &[Read], size_px: [u32; 2]) -> Vec<f32> {
    let [width, height] = size_px.map(|side| side as usize);
    let mut ink = vec![0.0_f32; width * height];
    for read in paths {
        let mut stamp = |at: Point| {
            // A stroke narrower than a pixel covers a part of it as large as its width.
            let reach = 0.5 * read.width.max(1.0) + 0.5;
            let opacity = read.opacity * read.width.min(1.0);
            let range = |middle: f64, most: usize| {
                (middle - reach - 1.0).max(0.0) as usize..((middle + reach + 1.0).max(0.0) as usize).min(most)
            };
            for (x, y) in range(at.y, height).flat_map(|y| range(at.x, width).map(move |x| (x, y))) {
                let distance = at.distance(Point::new(x as f64 + 0.5, y as f64 + 0.5));
                let covered = (reach - distance).clamp(0.0, 1.0) * opacity;
                ink[y * width + x] = ink[y * width + x].max(covered as f32);
            }
        };
        for segment in read.path.segments() {
            let steps = (segment.to_cubic().control_length() * 8.0).ceil().max(1.0) as usize;
            (0..=steps).for_each(|i| stamp(segment.eval(i as f64 / steps as f64)));
        }
    }
    ink
}

trait ControlLength {
    fn control_length(&self) -> f64;
}

impl ControlLength for kurbo::CubicBez {
    fn control_length(&self) -> f64 {
        self.p0.distance(self.p1) + self.p1.distance(self.p2) + self.p2.distance(self.p3)
    }
}

/// Returns the part of the pixels with `own` ink that have some `other` ink within 1.5 px.
fn covered(own: &[f32], other: &[f32]) -> f64 {
    let [width, height] = SIZE_PX.map(i64::from);
    let near: Vec<(i64, i64)> = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).collect();
    let (mut all, mut found) = (0_u32, 0_u32);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        if own[(y * width + x) as usize] < 0.12 {
            continue;
        }
        all += 1;
        let has_ink = |(dx, dy): &(i64, i64)| {
            let (x, y) = (x + dx, y + dy);
            (0..width).contains(&x) && (0..height).contains(&y) && other[(y * width + x) as usize] > 0.04
        };
        found += u32::from(near.iter().any(has_ink));
    }
    assert!(all > 500, "a picture must have more than 500 inked pixels, not {all}");
    f64::from(found) / f64::from(all)
}

#[test]
fn a_file_shows_what_was_drawn() {
    let real = || World::real("dem/geotiff/mt_rainier_90m.tif", 1.0);
    for (name, world, camera) in [("hill", hill(), HILL), ("Rainier", full().then(real).flatten(), RAINIER)] {
        let Some(mut world) = world else { continue };
        // Ink that does not fade, because SVG would mix it differently.
        let drawn = strokes_of(&mut world, camera, |strokes| {
            strokes.faintest = 1.0;
            // The hill's strokes taper along their whole length, so their width varies.
            if name == "hill" {
                (strokes.width_px, strokes.taper_px) = (5.0, 500.0);
            }
        });
        let settings = settings(Sheet::pixels(SIZE_PX));
        let (text, report) = written(&drawn.polylines, &settings);
        let paths = read(&text);
        assert_eq!((paths.len(), report.strokes), (drawn.polylines.len(), drawn.polylines.len() as u64));
        assert!(paths.iter().all(|read| read.opacity == 1.0));
        let again = rasterised(&paths);
        let (recall, precision) = (covered(&drawn.ink, &again), covered(&again, &drawn.ink));
        let area = |ink: &[f32]| ink.iter().map(|ink| f64::from(*ink)).sum::<f64>();
        let ratio = area(&again) / area(&drawn.ink);
        println!(
            "{name}: {} strokes of {} segments; recall {:.2} %, precision {:.2} %, {ratio:.3} \
             times as much ink; pen up {:.0} px instead of {:.0}",
            report.strokes,
            report.segments,
            100.0 * recall,
            100.0 * precision,
            report.pen_up_px,
            report.pen_up_unordered_px
        );
        assert!(recall >= 0.98 && precision >= 0.98 && (0.95..1.05).contains(&ratio));
        assert!(report.pen_up_px <= report.pen_up_unordered_px);
        // Planted: all strokes lower; the longest fifth of the strokes missing; too wide strokes.
        let changed = |change: &dyn Fn(&mut Vec<Read>)| {
            let mut paths = read(&text);
            change(&mut paths);
            rasterised(&paths)
        };
        let lower = changed(&|paths| {
            let down = kurbo::Affine::translate((0.0, 5.0));
            paths.iter_mut().for_each(|read| read.path.apply_affine(down));
        });
        assert!(covered(&drawn.ink, &lower) < 0.9 && covered(&lower, &drawn.ink) < 0.9);
        let fewer = changed(&|paths| {
            paths.sort_by(|a, b| a.path.perimeter(0.1).total_cmp(&b.path.perimeter(0.1)));
            paths.truncate(paths.len() - paths.len().div_ceil(5));
        });
        assert!(covered(&drawn.ink, &fewer) < 0.98);
        let wider = changed(&|paths| paths.iter_mut().for_each(|read| read.width *= 1.5));
        assert!(area(&wider) / area(&drawn.ink) > 1.1);
    }
}

/// Tests that another program draws the same.
#[test]
fn librsvg_agrees() {
    let Some(mut world) = hill() else { return };
    if Command::new("rsvg-convert").arg("--version").output().is_err() {
        return println!("skipped: rsvg-convert is not installed");
    }
    let drawn = strokes_of(&mut world, HILL, |strokes| strokes.faintest = 1.0);
    let folder = tempfile::tempdir().unwrap();
    let [svg, png] = ["a.svg", "a.png"].map(|name| folder.path().join(name));
    let settings = settings(Sheet::pixels(SIZE_PX));
    let (layers, _) = layers(&groups(&drawn.polylines, settings.ink), &settings, None);
    write_svg(&svg, &drawing(layers, &settings), None).unwrap();
    let done = Command::new("rsvg-convert").arg(&svg).arg("-o").arg(&png).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let picture = hachure::file::png::read_rgba8(&png).unwrap();
    assert_eq!([picture.width, picture.height], SIZE_PX);
    // The picture has no background, so its alpha is the ink.
    let ink: Vec<f32> = picture.rgba.chunks_exact(4).map(|texel| f32::from(texel[3]) / 255.0).collect();
    let (recall, precision) = (covered(&drawn.ink, &ink), covered(&ink, &drawn.ink));
    println!("librsvg: recall {:.2} %, precision {:.2} %", 100.0 * recall, 100.0 * precision);
    assert!(recall >= 0.98 && precision >= 0.98);
}
