//! Damaged copies of every format are errors or heights, never accidents.

use std::path::Path;

use hachure::source::{self, Silent};

use crate::windows::one_of_each;

/// A xorshift generator: the same damage in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit.max(1) as u64) as usize
    }
}

/// Opens what may be damaged, and holds what comes of it against what `open` promises.
fn open_damaged(path: &Path, named: &str) {
    match source::open(path, &Silent) {
        Ok(grid) => {
            assert_eq!(grid.heights_m.len(), grid.width as usize * grid.height as usize);
            assert!(grid.heights_m.iter().all(|height| height.is_nan() || height.abs() <= 1e6));
            assert!(grid.georeference.crs_from_grid.iter().all(|number| number.is_finite()));
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains(named) && !message.contains('\n'), "{message:?}");
            assert!(!message.contains("gave up"), "{message}");
        }
    }
}

fn damage(bytes: &[u8], random: &mut Random, header: usize) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    if random.below(3) == 0 {
        damaged.truncate(random.below(bytes.len()));
    }
    for _ in 0..1 + random.below(5) {
        // Half of the damage goes where it hurts.
        let limit = if random.below(2) == 0 { header.min(damaged.len()) } else { damaged.len() };
        let (at, value) = (random.below(limit), random.below(256) as u8);
        if let Some(byte) = damaged.get_mut(at) {
            *byte = value;
        }
    }
    damaged
}

#[test]
fn damaged_files_are_errors_or_heights() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for path in one_of_each(folder.path()) {
        let bytes = std::fs::read(&path).unwrap();
        let copies = if bytes.len() > 100_000 { 40 } else { 400 };
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        for _ in 0..copies {
            std::fs::write(&path, damage(&bytes, &mut random, 1100)).unwrap();
            open_damaged(&path, &stem);
        }
    }
}

#[test]
fn damaged_headers_and_side_files_are_errors_or_heights() {
    let folder = tempfile::tempdir().unwrap();
    one_of_each(folder.path());
    std::fs::write(
        folder.path().join("j.r16.toml"),
        "width = 50\nheight = 50\nspacing_m = 3\nheight_scale_m = 1\ncrs = \"EPSG:32610\"\norigin = [1.0, 2.0]\n",
    )
    .unwrap();
    let mut random = Random(0x1234_5678_9abc_def1);
    for (data, beside) in [
        ("d.bil", "d.hdr"),
        ("d.bil", "d.prj"),
        ("e.flt", "e.hdr"),
        ("e.flt", "e.prj"),
        ("f.img", "f.hdr"),
        ("j.r16", "j.r16.toml"),
    ] {
        let beside = folder.path().join(beside);
        let bytes = std::fs::read(&beside).unwrap();
        for _ in 0..400 {
            std::fs::write(&beside, damage(&bytes, &mut random, bytes.len())).unwrap();
            open_damaged(&folder.path().join(data), &data[..1]);
        }
        std::fs::write(&beside, &bytes).unwrap();
    }
}
