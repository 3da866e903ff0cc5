//! Variants of GeoTIFF that libtiff, and so GDAL, reads; each was once read wrongly or refused.

use std::path::Path;

use hachure::pyramid::TileAddress;
use hachure::pyramid::Voids;
use hachure::pyramid::store::open_local_cog;
use hachure::source::{self, Silent};

use crate::compare::{check, compare};
use crate::dem::Dem;
use crate::tiff::{self, Picture, STRIPS, TILES, Value, bytes, samples, short, write};
use crate::write::NOWHERE;

fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// A function that compresses a block.
type Pack = fn(&[u8]) -> Vec<u8>;

/// Returns the strips of `rows` rows; the last one is filled up with `padding`.
fn strips(dem: &Dem, rows: usize, padding: i16) -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<i16>> = dem.heights.chunks(rows * dem.width).map(<[i16]>::to_vec).collect();
    if let Some(last) = all.last_mut() {
        last.resize(rows * dem.width, padding);
    }
    all.iter().map(|strip| bytes(strip)).collect()
}

#[test]
fn a_last_strip_may_be_padded() {
    let folder = scratch();
    // Four strips of 4 rows for 14 rows: the last one has 2 too many.
    let dem = Dem::new(50, 14, 4);
    let codecs: [(u16, Pack); 5] =
        [(1, <[u8]>::to_vec), (5, tiff::lzw), (8, tiff::deflate), (32_773, tiff::pack_bits), (50_000, tiff::zstd)];
    for (code, pack) in codecs {
        let path = folder.path().join(format!("{code}.tif"));
        let mut picture = Picture::of_i16(&dem).with(278, short(4)).with(259, short(code));
        picture = picture.with(42_113, Value::Ascii("-32768".to_owned()));
        picture.blocks = strips(&dem, 4, 8000).iter().map(|strip| pack(strip)).collect();
        write(&path, std::slice::from_ref(&picture));
        check(&path, &dem, NOWHERE);
        // A file whose last row is missing is still damaged. (Uncompressed samples may be followed by any bytes.)
        if ![1, 50_000].contains(&code) {
            let mut short_of_a_row = picture.clone();
            short_of_a_row.blocks[3] = pack(&bytes(&dem.heights[12 * 50..13 * 50]));
            write(&path, &[short_of_a_row]);
            let error = source::open(&path, &Silent).unwrap_err().to_string();
            assert!(error.contains("damaged") && error.contains(&format!("{code}.tif")), "{error}");
        }
        // Planted error: the padding in place of the rows.
        let mut moved = picture.clone();
        moved.blocks[3] = pack(&bytes(&[8000; 200]));
        write(&path, &[moved]);
        let found = compare(&source::open(&path, &Silent).unwrap(), &dem, NOWHERE);
        assert!(found.is_err_and(|error| error.contains("sample 600")));
    }
}

#[test]
fn places_of_tiles_may_stand_under_the_tags_of_strips() {
    let folder = scratch();
    let dem = Dem::new(40, 20, 0);
    let path = folder.path().join("tiles.tif");
    let tile = |x: usize, y: usize| -> Vec<u8> {
        let at = |row: usize, column: usize| if row < 20 && column < 40 { dem.at(column, row) } else { 9 };
        let samples = (y..y + 16).flat_map(|row| (x..x + 16).map(move |column| at(row, column)));
        bytes(&samples.collect::<Vec<_>>())
    };
    let mut picture = Picture::of_i16(&dem).with(322, short(16)).with(323, short(16));
    picture.tags.retain(|tag| tag.0 != 278);
    picture.blocks = [0, 16].into_iter().flat_map(|y| [0, 16, 32].map(|x| tile(x, y))).collect();
    for places in [STRIPS, TILES] {
        picture.places = places;
        write(&path, std::slice::from_ref(&picture));
        check(&path, &dem, NOWHERE);
    }
}

/// The values `100 + 10 i - 3 (i mod 7)` for 48 samples, as packed by `xz` of liblzma 5.4 with the filters of libtiff.
const LZMA: [u8; 76] = [
    253, 55, 122, 88, 90, 0, 0, 1, 105, 34, 222, 54, 2, 1, 3, 1, 1, 33, 1, 0, 77, 242, 172, 162, 224, 0, 95, 0, 20, 93,
    0, 49, 255, 252, 244, 3, 254, 20, 124, 254, 194, 35, 176, 3, 79, 152, 21, 242, 44, 96, 0, 0, 226, 85, 93, 220, 0,
    1, 44, 96, 221, 191, 5, 84, 144, 66, 153, 13, 1, 0, 0, 0, 0, 1, 89, 90,
];

#[test]
fn lzma_is_read() {
    let folder = scratch();
    let heights = (0..48).map(|i| 100 + 10 * i - 3 * (i % 7)).collect();
    let dem = Dem { width: 8, height: 6, heights };
    let path = folder.path().join("lzma.tif");
    let mut picture = Picture::of_i16(&dem).with(259, short(34_925));
    picture.blocks = vec![LZMA.to_vec()];
    write(&path, std::slice::from_ref(&picture));
    check(&path, &dem, NOWHERE);
    // The checksum finds a changed byte.
    picture.blocks[0][35] ^= 4;
    write(&path, &[picture]);
    let error = source::open(&path, &Silent).unwrap_err();
    assert!(error.to_string().contains("lzma.tif: is damaged"), "{error}");
}

#[test]
fn samples_of_odd_sizes_are_read() {
    let folder = scratch();
    let path = folder.path().join("odd.tif");
    let open = |bits: u16, format: u16, block: Vec<u8>| {
        let picture = Picture { size: [4, 2], tags: samples(bits, format), places: STRIPS, blocks: vec![block] };
        write(&path, &[picture.with(278, short(2))]);
        source::open(&path, &Silent).unwrap_or_else(|error| panic!("{bits}: {error}")).heights_m
    };
    let halves = [0x3c00u16, 0xc000, 0x6000, 0x7bff, 0, 0x3800, 0x4248, 0x7e00];
    let heights = open(16, 3, halves.iter().flat_map(|it| it.to_le_bytes()).collect());
    assert_eq!(heights[..7], [1.0, -2.0, 512.0, 65_504.0, 0.0, 0.5, 3.140_625]);
    assert!(heights[7].is_nan());
    // 12 bits and 20 bits per sample; each row begins with a new byte.
    let twelve = [0x00, 0x10, 0x02, 0x00, 0x3f, 0xff, 0x10, 0x00, 0x01, 0xff, 0xe0, 0x00];
    assert_eq!(open(12, 1, twelve.to_vec()), [1.0, 2.0, 3.0, 4095.0, 256.0, 1.0, 4094.0, 0.0]);
    let mut twenty = vec![0, 0, 0x10, 0, 0x02, 0x01, 0, 0x0f, 0xff, 0xff];
    twenty.extend([0; 10]);
    // 1048575 m is beyond the limit of heights.
    let heights = open(20, 1, twenty);
    assert_eq!(heights[..3], [1.0, 2.0, 4096.0]);
    assert!(heights[3].is_nan());
}

/// Returns the heights where `is_shown`, and a mask of one bit per sample.
fn masked(dem: &Dem, is_shown: impl Fn(usize, usize) -> bool) -> (Dem, Picture) {
    let mut expected = dem.clone();
    let mut rows = Vec::new();
    for row in 0..dem.height {
        let mut bits = vec![0u8; dem.width.div_ceil(8)];
        for column in 0..dem.width {
            match is_shown(column, row) {
                true => bits[column / 8] |= 0x80 >> (column % 8),
                false => expected.heights[row * dem.width + column] = i16::MIN,
            }
        }
        rows.extend(bits);
    }
    let size = [dem.width as u32, dem.height as u32];
    let mask = Picture { size, tags: samples(1, 1), places: STRIPS, blocks: vec![rows] };
    (expected, mask.with(278, short(dem.height as u16)).with(262, short(4)).with(254, short(4)))
}

fn is_shown(column: usize, row: usize) -> bool {
    !(column + 2 * row).is_multiple_of(5) && column < 30
}

#[test]
fn masks_are_voids() {
    let folder = scratch();
    let dem = Dem::new(37, 21, 0);
    let (expected, mask) = masked(&dem, is_shown);
    let path = folder.path().join("internal.tif");
    write(&path, &[Picture::of_i16(&dem), mask.clone()]);
    check(&path, &expected, NOWHERE);
    // The mask of a COG may be compressed, like the heights.
    let mut packed = Picture::of_i16(&dem).with(259, short(8));
    packed.blocks[0] = tiff::deflate(&packed.blocks[0]);
    let mut packed_mask = mask.clone().with(259, short(8));
    packed_mask.blocks[0] = tiff::deflate(&packed_mask.blocks[0]);
    write(&path, &[packed, packed_mask.clone()]);
    check(&path, &expected, NOWHERE);
    let hidden = source::open_reader(&path).unwrap().identity();
    // The COG is drawn without a bake.
    let store = open_local_cog(&path).unwrap().expect("the file must be accepted as a COG of one level");
    let tile = store.load(TileAddress { level: 0, x: 0, y: 0 }).unwrap();
    assert_ne!(tile.statistics.voids, Voids::None);

    // Planted errors: a file without its mask, and a mask that cannot be decoded.
    write(&path, &[Picture::of_i16(&dem)]);
    assert!(compare(&source::open(&path, &Silent).unwrap(), &expected, NOWHERE).is_err());
    assert_ne!(source::open_reader(&path).unwrap().identity(), hidden);
    packed_mask.blocks[0].truncate(20);
    write(&path, &[Picture::of_i16(&dem), packed_mask]);
    let error = source::open(&path, &Silent).unwrap_err().to_string();
    assert!(error.contains("internal.tif: is damaged"), "{error}");

    // A mask in a separate file, as GDAL writes it by default.
    let path = folder.path().join("masked.tif");
    write(&path, &[Picture::of_i16(&dem)]);
    let bare = source::open_reader(&path).unwrap().identity();
    write(&folder.path().join("masked.tif.msk"), std::slice::from_ref(&mask));
    check(&path, &expected, NOWHERE);
    assert_ne!(
        source::open_reader(&path).unwrap().identity(),
        bare,
        "the mask does not change the identity, so a stale cache would be used"
    );
    assert!(open_local_cog(&path).unwrap().is_none(), "a file with a separate mask must not be drawn as a COG");
    // A mask of another size is ignored.
    write(&folder.path().join("masked.tif.msk"), &[masked(&Dem::new(20, 21, 0), is_shown).1]);
    check(&path, &dem, NOWHERE);
}

#[test]
fn a_band_of_opacity_hides_heights() {
    let folder = scratch();
    let dem = Dem::new(37, 21, 0);
    let (expected, _) = masked(&dem, is_shown);
    let path = folder.path().join("opacity.tif");
    let opacity = |index: usize| if is_shown(index % 37, index / 37) { 255i16 } else { 0 };
    let mut picture = Picture::of_i16(&dem).with(277, short(2)).with(258, Value::Short(vec![16; 2]));
    picture = picture.with(339, Value::Short(vec![2; 2]));
    picture.blocks = vec![dem.heights.iter().enumerate().flat_map(|(i, &it)| bytes(&[it, opacity(i)])).collect()];
    // ExtraSamples (338): 2 is alpha, 0 is unspecified.
    write(&path, &[picture.clone().with(338, short(2))]);
    check(&path, &expected, NOWHERE);
    write(&path, &[picture.with(338, short(0))]);
    check(&path, &dem, NOWHERE);
}

#[test]
fn sidecar_files_place_a_tiff() {
    let folder = scratch();
    let dem = Dem::new(30, 20, 0);
    let path = folder.path().join("scan.tif");
    write(&path, &[Picture::of_i16(&dem)]);
    let bare = source::open_reader(&path).unwrap().identity();
    std::fs::write(folder.path().join("scan.tfw"), "30\n0\n0\n-30\n594015\n5194985\n").unwrap();
    check(&path, &dem, [594_015.0, 30.0, 0.0, 5_194_985.0, 0.0, -30.0]);
    assert_ne!(source::open_reader(&path).unwrap().identity(), bare);
    // GDAL's .aux.xml takes precedence over the world file, and gives no-data too.
    let aux = folder.path().join("scan.tif.aux.xml");
    let utm = r#"PROJCS["x",UNIT["metre",1],AUTHORITY["EPSG","32610"]]"#;
    let place = "<GeoTransform>600000, 20, 0, 5200000, 0, -20</GeoTransform>";
    let text = format!("<PAMDataset><SRS>{utm}</SRS>{place}</PAMDataset>");
    std::fs::write(&aux, text).unwrap();
    let grid = check(&path, &dem, [600_010.0, 20.0, 0.0, 5_199_990.0, 0.0, -20.0]);
    assert_eq!(grid.georeference.geokeys.epsg, Some(32610));
    let mark = dem.heights[7];
    let band = format!("<PAMRasterBand band=\"1\"><NoDataValue>{mark}</NoDataValue></PAMRasterBand>");
    std::fs::write(&aux, format!("<PAMDataset>{place}{band}</PAMDataset>")).unwrap();
    let grid = source::open(&path, &Silent).unwrap();
    assert!(grid.heights_m[7].is_nan() && grid.heights_m.iter().any(|height| height.is_finite()));
}

#[test]
fn an_erdas_file_next_to_an_envi_header_is_called_by_its_name() {
    let folder = scratch();
    let header = "ENVI\nsamples = 20\nlines = 20\nbands = 1\ndata type = 2\ninterleave = bsq\nbyte order = 0\n";
    std::fs::write(folder.path().join("dem.hdr"), header).unwrap();
    let mut bytes = b"EHFA_HEADER_TAG\0".to_vec();
    bytes.resize(4000, 1);
    std::fs::write(folder.path().join("dem.img"), &bytes).unwrap();
    let refusal = |path: &Path| source::open(path, &Silent).unwrap_err().to_string();
    for name in ["dem.img", "dem.hdr"] {
        let error = refusal(&folder.path().join(name));
        assert!(error.contains("dem.img: is an ERDAS Imagine file") && error.contains("gdal_translate"), "{error}");
    }
    // Without the Erdas signature, the ENVI header applies.
    bytes[0] = 0;
    std::fs::write(folder.path().join("dem.img"), &bytes).unwrap();
    assert!(source::open(&folder.path().join("dem.img"), &Silent).is_ok());
}
