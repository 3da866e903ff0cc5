use super::forest::{Threshold, reduce};
use super::reference::{EIGHT, Land, Reference};
use super::sample::Sample;
use super::spacing::WGS_84_RADII_M;
use super::tile::{TileArea, tile_forest, whole_forest};
use super::{Heights, Peak, Rules, Spacing, peaks};

const PLANE: Spacing = Spacing::Metres([30.0, 20.0]);

/// A generator of numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1_u64 << 24) as f64
    }
}

fn noise(size: [usize; 2], seed: u64) -> Land {
    let mut random = Random(seed);
    let heights_m = (0..size[0] * size[1]).map(|_| (900.0 * random.next() - 100.0) as f32).collect();
    Land { size, heights_m }
}

/// Land of which coarse features are as much higher as they are larger. Its columns wrap.
fn fractal(size: [usize; 2], seed: u64) -> Land {
    let mut heights_m = vec![0.0; size[0] * size[1]];
    for octave in 0..5 {
        let step = 16 >> octave;
        let corners = size.map(|side| side.div_ceil(step));
        let Land { heights_m: values, .. } = noise([corners[0], corners[1] + 1], seed + octave as u64);
        for (at, height_m) in heights_m.iter_mut().enumerate() {
            let [x, y] = [at % size[0], at / size[0]];
            let value = |dx: usize, dy: usize| values[(y / step + dy) * corners[0] + (x / step + dx) % corners[0]];
            let [u, v] = [x, y].map(|at| (at % step) as f32 / step as f32);
            let across = |dy: usize| value(0, dy) * (1.0 - u) + value(1, dy) * u;
            *height_m += (across(0) * (1.0 - v) + across(1) * v) * step as f32 / 16.0;
        }
    }
    Land { size, heights_m }
}

/// Rounds heights to multiples of a step in metres.
fn rounded(mut land: Land, step_m: f32) -> Land {
    land.heights_m.iter_mut().for_each(|height_m| *height_m = (*height_m / step_m).round() * step_m);
    land
}

/// Removes single samples and everything below a height.
fn holed(mut land: Land, part: f64, least_m: f32) -> Land {
    let mut random = Random(99);
    for height_m in &mut land.heights_m {
        if random.next() < part || *height_m < least_m {
            *height_m = f32::NAN;
        }
    }
    land
}

fn found(land: &Land, rules: &Rules) -> Vec<Peak> {
    peaks(&mut land.clone(), rules, &mut |_| true).unwrap().unwrap()
}

fn expected(land: &Land, rules: &Rules) -> Vec<Peak> {
    Reference { land, rules, around: &EIGHT }.peaks()
}

/// Returns the first difference of two results, which must be equal bit for bit.
fn difference(found: &[Peak], expected: &[Peak]) -> Option<String> {
    if found.len() != expected.len() {
        return Some(format!("{} peaks instead of {}", found.len(), expected.len()));
    }
    // No height of the result is −0, so equal numbers have equal bits.
    let (found, expected) = found.iter().zip(expected).find(|(found, expected)| found != expected)?;
    Some(format!("{found:#?} instead of {expected:#?}"))
}

/// Checks all tile sizes against floods.
fn check(land: &Land, rules: &Rules) -> usize {
    let expected = expected(land, rules);
    for (tile, block) in [(1, 1), (3, 4), (7, 5), (19, 16), (1024, 64)] {
        let rules = Rules { tile, block, ..*rules };
        if let Some(difference) = difference(&found(land, &rules), &expected) {
            panic!("{:?}, {rules:?}: {difference}", land.size);
        }
    }
    expected.len()
}

#[test]
fn equals_floods_on_any_land_with_any_tiles() {
    let globe = Spacing::Degrees { north: 89.0, step: [7.5, 4.1], radii_m: WGS_84_RADII_M };
    let alps = Spacing::Degrees { north: 47.0, step: [0.01, 0.01], radii_m: WGS_84_RADII_M };
    let lands = [
        fractal([48, 43], 1),
        noise([48, 23], 2),
        rounded(fractal([48, 43], 3), 40.0),
        rounded(noise([48, 29], 4), 300.0),
        holed(fractal([48, 43], 5), 0.03, 300.0),
        holed(rounded(noise([48, 43], 6), 200.0), 0.4, -1e9),
    ];
    let mut count = 0;
    for (index, land) in lands.iter().enumerate() {
        let rules = Rules::new(PLANE);
        count += check(land, &Rules { has_open_gaps: index % 2 == 0, ..rules });
        count += check(land, &Rules { spacing: globe, wraps: true, has_open_gaps: index % 2 == 1, ..rules });
        count += check(land, &Rules { spacing: alps, least_prominence_m: 60.0, sea_level_m: None, ..rules });
        count += check(land, &Rules { least_prominence_m: 20.0, most: 7, wraps: true, ..rules });
    }
    assert!(count > 1500, "{count} peaks");
}

#[test]
fn equals_floods_on_narrow_land() {
    for size in [[1, 1], [1, 40], [40, 1], [2, 2], [2, 9], [9, 2], [3, 3], [3, 8], [4, 1]] {
        for seed in 0..8 {
            let land = holed(rounded(noise(size, seed), 50.0), if seed < 4 { 0.0 } else { 0.3 }, -1e9);
            for wraps in [false, true] {
                check(&land, &Rules { wraps, has_open_gaps: seed % 2 == 0, ..Rules::new(PLANE) });
            }
        }
    }
}

#[test]
fn land_without_relief_or_data() {
    let rules = Rules::new(PLANE);
    let flat = |height_m: f32| Land { size: [9, 5], heights_m: vec![height_m; 45] };
    for height_m in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, -5.0, 500.0] {
        assert_eq!(check(&flat(height_m), &rules), 0);
    }
    assert_eq!(found(&Land { size: [0, 5], heights_m: Vec::new() }, &rules), []);
    // +0 and −0 are one plateau.
    let mut land = flat(-0.0);
    (0..45).step_by(2).for_each(|at| land.heights_m[at] = 0.0);
    assert_eq!(check(&land, &rules), 0);
    // A flat island is a summit above the sea.
    let mut island = flat(f32::NAN);
    [12, 13, 22].into_iter().for_each(|at| island.heights_m[at] = 500.0);
    assert_eq!(check(&island, &rules), 1);
    let peak = found(&island, &rules)[0];
    assert_eq!((peak.column, peak.row, peak.prominence_m, peak.certain_prominence_m), (3, 1, 500.0, 500.0));
    // If land may continue in the sea, nothing is known of it.
    assert_eq!(found(&island, &Rules { has_open_gaps: true, ..rules }), []);
    // Infinities are no data.
    island.heights_m[14] = f32::INFINITY;
    island.heights_m[30] = f32::NEG_INFINITY;
    assert_eq!(check(&island, &rules), 1);
}

#[test]
fn bounds_include_what_a_larger_dem_has() {
    // The prominence on a part of the land is never less than that on the whole, nor the certain one more.
    let whole = fractal([64, 64], 11);
    let rules = Rules::new(PLANE);
    let all = found(&whole, &rules);
    let mut part = Land { size: [30, 30], heights_m: Vec::new() };
    whole.clone().read([20, 10], [30, 30], &mut part.heights_m).unwrap();
    let (mut certain, mut uncertain) = (0, 0);
    for peak in found(&part, &rules) {
        let same = all.iter().find(|other| [other.column, other.row] == [peak.column + 20, peak.row + 10]);
        let Some(same) = same else {
            assert_eq!(peak.certain_prominence_m, 0.0, "{peak:?} is a summit only on the part");
            continue;
        };
        assert!(peak.certain_prominence_m <= same.prominence_m, "{peak:?} {same:?}");
        assert!(peak.key_saddle.is_none() || same.prominence_m <= peak.prominence_m, "{peak:?} {same:?}");
        if let (Some(higher), None) = (peak.isolation.higher, peak.isolation.outside_m) {
            assert_eq!(Some(higher.distance_m), same.isolation.higher.map(|higher| higher.distance_m));
            certain += 1;
        } else if let (Some(outside_m), Some(higher)) = (peak.isolation.outside_m, same.isolation.higher) {
            assert!(outside_m <= higher.distance_m, "{peak:?} {same:?}");
            uncertain += 1;
        }
    }
    assert!(certain > 10 && uncertain > 2, "{certain} {uncertain}");
}

#[test]
fn planted_errors_are_found() {
    let land = noise([48, 43], 21);
    let rules = Rules { tile: 7, block: 4, ..Rules::new(PLANE) };
    let result = found(&land, &rules);
    assert_eq!(difference(&result, &expected(&land, &rules)), None);
    // Diagonal neighbours are missing.
    let four = Reference { land: &land, rules: &rules, around: &EIGHT[..4] }.peaks();
    assert!(difference(&result, &four).is_some());
    // A saddle is 1 m higher.
    let saddle = result[1].key_saddle.unwrap();
    let mut raised = land.clone();
    raised.heights_m[saddle.row * 48 + saddle.column] += 1.0;
    assert!(difference(&result, &expected(&raised, &rules)).is_some());
    // One summit is missing, or has another saddle, nearest sample or distance.
    assert!(difference(&result[1..], &expected(&land, &rules)).is_some());
    type Change = fn(&mut Peak);
    let changes: [Change; 4] = [
        |peak| peak.key_saddle.as_mut().unwrap().column += 1,
        |peak| peak.isolation.higher.as_mut().unwrap().row += 1,
        |peak| peak.isolation.outside_m = Some(peak.isolation.outside_m.map_or(1.0, |outside_m| 2.0 * outside_m)),
        |peak| peak.certain_prominence_m = peak.certain_prominence_m.next_up(),
    ];
    for change in changes {
        let mut changed = result.clone();
        change(&mut changed[3]);
        assert!(difference(&changed, &expected(&land, &rules)).is_some());
    }
    // The nearest higher sample is sought only in the block of the summit.
    let reference = Reference { land: &land, rules: &rules, around: &EIGHT };
    let is_wrong = |peak: &&Peak| {
        let in_block = |at: usize| [at % 48 / 4, at / 48 / 4] == [peak.column / 4, peak.row / 4];
        reference.isolation(peak.row * 48 + peak.column, in_block) != peak.isolation
    };
    assert!(result.iter().filter(is_wrong).count() > 20);
}

#[test]
fn a_tile_needs_its_front() {
    let land = fractal([48, 48], 31);
    let rules = Rules::new(PLANE);
    let all = found(&land, &rules);
    let area = TileArea { first: [16, 16], size: [17, 17], dem: land.size, is_shared: [true; 4] };
    let mut heights_m = Vec::new();
    land.clone().read(area.first, area.size, &mut heights_m).unwrap();
    let is_right = |peak: Sample, saddle: Sample| {
        let [column, row] = peak.place(48);
        let same = all.iter().find(|other| [other.column, other.row] == [column, row]);
        same.and_then(|same| same.key_saddle).is_some_and(|key| [key.column, key.row] == saddle.place(48))
    };
    let threshold = Threshold { least_m: 0.0 };
    let with_front = tile_forest(area, &heights_m, false, threshold);
    assert!(!with_front.found.is_empty());
    assert!(with_front.found.iter().all(|found| is_right(found.peak, found.saddle)));
    // Without the front, all summits end in the tile, and some of them wrongly.
    let (forest, _) = whole_forest(area, &heights_m, false);
    let without_front = reduce(forest, threshold);
    assert!(without_front.forest.nodes.is_empty());
    assert!(without_front.found.len() > with_front.found.len());
    assert!(!without_front.found.iter().all(|found| is_right(found.peak, found.saddle)));
}

#[test]
fn a_tile_keeps_only_its_border() {
    let side = 257;
    let land = noise([side; 2], 41);
    let area = TileArea { first: [0; 2], size: [side; 2], dem: [4 * side; 2], is_shared: [true; 4] };
    let (whole, _) = whole_forest(area, &land.heights_m, false);
    let tile = tile_forest(area, &land.heights_m, false, Threshold { least_m: 100.0 });
    assert!(whole.nodes.len() > 7000, "{}", whole.nodes.len());
    assert!(tile.forest.nodes.len() < 2 * side, "{}", tile.forest.nodes.len());
    assert_eq!(tile.forest.edges.len() + 1, tile.forest.nodes.len());
}

#[test]
fn is_cancelled_and_passes_errors_on() {
    let mut land = noise([40, 40], 51);
    let rules = Rules { tile: 10, ..Rules::new(PLANE) };
    let mut parts = Vec::new();
    peaks(&mut land, &rules, &mut |part| {
        parts.push(part);
        true
    })
    .unwrap();
    assert!(parts.is_sorted() && parts.last() == Some(&1.0));
    for last in [0, 5, 20] {
        let mut calls = 0;
        let result = peaks(&mut land, &rules, &mut |_| {
            calls += 1;
            calls <= last
        });
        assert_eq!((result, calls), (Ok(None), last + 1));
    }
    /// Heights that cannot be read beyond a number of times.
    struct Failing(Land, usize);
    impl Heights for Failing {
        type Error = usize;
        fn size(&self) -> [usize; 2] {
            self.0.size
        }
        fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), usize> {
            self.1 = self.1.checked_sub(1).ok_or(first[0])?;
            self.0.read(first, size, into).map_err(|error| match error {})
        }
    }
    assert_eq!(peaks(&mut Failing(land.clone(), 1), &rules, &mut |_| true), Err(10));
    assert!(peaks(&mut Failing(land, 16), &rules, &mut |_| true).is_err());
}

/// Files of real heights, of many sources and kinds of land.
const REAL: [&str; 20] = [
    "dem/geotiff/N46E008_alps.tif",
    "dem/geotiff/N49W123.tif",
    "dem/asc/spearfish_dem.asc",
    "dem/geotiff/N49W124.tif",
    "dem/geotiff/craterlake-elev-16bit-30m.tif",
    "dem/geotiff/dem_south_pole.tif",
    "dem/geotiff/ds_los_angeles_tile_0.tif",
    "dem/geotiff/elev_vinschgau.tif",
    "dem/geotiff/etopo1_1deg.tif",
    "dem/geotiff/gt_diffproj_sfdem.tif",
    "dem/geotiff/mt_everest_90m.tif",
    "dem/geotiff/mt_rainier_90m.tif",
    "dem/geotiff/riorgbify_elev.tif",
    "dem/geotiff/whitebox_DEM.tif",
    "dem/geotiff/zh_dem_25.tif",
    "dem/asc/095b_dem_90m.asc",
    "dem/asc/ll_SRTMGL3_front_range.asc",
    "dem/hgt/N42E001.hgt",
    "dem/usgsdem/SainteHelens.dem",
    "dem/dted/n43.dt0",
];

/// Compares the middle of real DEMs, with their voids and the steps of whole metres, with floods: of all files in the long
/// tier. Planted: a sample in the middle that is higher than all others.
#[test]
fn equals_floods_on_real_land() {
    let (files, side) = if crate::tests::common::full() { (REAL.len(), 240) } else { (3, 90) };
    let (mut count, mut voids) = (0, 0);
    for name in &REAL[..files] {
        let Some(path) = crate::tests::common::real_data(name) else { continue };
        let reader = crate::source::open_reader(&path).unwrap();
        let grid = crate::source::read_all(&*reader, &path, &crate::source::Silent).unwrap();
        let [width, height] = [grid.width as usize, grid.height as usize];
        let size = [width.min(side), height.min(side)];
        let [left, top] = [(width - size[0]) / 2, (height - size[1]) / 2];
        let rows = (top..top + size[1]).map(|row| &grid.heights_m[row * width + left..][..size[0]]);
        let land = Land { size, heights_m: rows.flatten().copied().collect() };
        let rules = Rules { tile: 64, block: 16, has_open_gaps: true, ..Rules::new(PLANE) };
        let expected = expected(&land, &rules);
        let difference_of = |land: &Land| difference(&found(land, &rules), &expected);
        assert!(difference_of(&land).is_none(), "{name}: {}", difference_of(&land).unwrap());
        assert!(!expected.is_empty(), "{name} has no summits");
        voids += land.heights_m.iter().filter(|height_m| height_m.is_nan()).count();
        let mut planted = land.clone();
        planted.heights_m[(size[1] / 2) * size[0] + size[0] / 2] = 9000.0;
        assert!(difference_of(&planted).is_some(), "{name}: planted");
        count += expected.len();
    }
    // Without the files nothing is compared.
    assert!(
        count == 0 || files < REAL.len() || count > 2000 && voids > 0,
        "{count} summits, {voids} samples without data"
    );
}
