//! Measures the time and memory of baking a grid that does not fit into memory. Run by hand:
//!
//! `HACHURE_LARGE=40000 cargo test --release --test bake -- --ignored --nocapture large`

use std::sync::atomic::{AtomicU64, Ordering};

use hachure::internals::rss_bytes;
use hachure::pyramid::bake::{BakeWork, Baked, bake_reader};
use hachure::pyramid::{BakeOptions, Pyramid};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{HeightReader, Silent, SourceError, Window};

/// A reader that computes hills with small roughness from a formula.
struct Formula {
    side: u32,
    georeference: Georeference,
    read: AtomicU64,
}

impl HeightReader for Formula {
    fn size(&self) -> [u32; 2] {
        [self.side; 2]
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        self.read.fetch_add(window.samples() as u64, Ordering::Relaxed);
        let wave = |at: u32, length: f32| (at as f32 / length).sin();
        let columns: Vec<[f32; 3]> =
            (window.x..window.x + window.width).map(|x| [wave(x, 911.0), wave(x, 83.0), wave(x, 17.0)]).collect();
        let mut heights_m = Vec::with_capacity(window.samples());
        for y in window.y..window.y + window.height {
            let row = [wave(y, 733.0), wave(y, 71.0), wave(y, 13.0)];
            heights_m.extend((window.x..).zip(&columns).map(|(x, column)| {
                let noise = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(2_246_822_519)).wrapping_mul(3_266_489_917);
                let noise = (noise >> 8) as f32 / 16_777_216.0;
                1500.0 + 700.0 * column[0] * row[0] + 60.0 * column[1] * row[1] + 5.0 * column[2] * row[2] + 0.3 * noise
            }));
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [512, 512]
    }

    fn identity(&self) -> String {
        format!("formula {}", self.side)
    }
}

#[test]
#[ignore = "takes minutes and disk"]
fn large() {
    let side: u32 = std::env::var("HACHURE_LARGE").ok().and_then(|text| text.parse().ok()).unwrap_or(20_000);
    let max_error_m = std::env::var("HACHURE_LARGE_ERROR").ok().and_then(|text| text.parse().ok()).unwrap_or(0.05);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("large.tif");
    let crs_from_grid = [0.0, 10.0, 0.0, 0.0, 0.0, -10.0];
    let georeference = Georeference { crs_from_grid, crs: Crs::Local, geokeys: Default::default() };
    let reader = Formula { side, georeference, read: AtomicU64::new(0) };
    let work = BakeWork { in_folder: true, ..BakeWork::default() };
    let baked = bake_reader(&reader, &out, &BakeOptions { max_error_m }, &work, &Silent).unwrap();
    let Baked::Pyramid(report) = baked else { panic!("the bake made a shard instead of a pyramid") };
    let samples = f64::from(side).powi(2);
    let peak = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = peak.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("VmHWM unknown");
    println!(
        "{side}²: {:.1} s, {:.2} M samples/s, {peak}, rss {:?}, read {:.3} times, tif {:.3} bits, sidecar {:.3} bits a sample",
        report.duration.as_secs_f64(),
        samples / 1e6 / report.duration.as_secs_f64(),
        rss_bytes(),
        reader.read.load(Ordering::Relaxed) as f64 / samples,
        report.tif_bytes as f64 * 8.0 / samples,
        report.sidecar_bytes as f64 * 8.0 / samples,
    );
    let opened = std::time::Instant::now();
    let pyramid = Pyramid::open(&out).unwrap();
    println!("opened in {:.3} ms, {} levels", opened.elapsed().as_secs_f64() * 1e3, pyramid.levels().len());
}
