//! Writers of every format, by their specifications; each returns the `crs_from_grid` of its file.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use netcdf_writer::{NcAttrValue, NcFileBuilder, NcWriteFormat, NcWriteOptions};

use crate::dem::Dem;

pub(crate) const WEST: f64 = 594_000.0;
/// A multiple of the spacing, as in USGS DEMs in UTM.
pub(crate) const NORTH: f64 = 5_195_010.0;
pub(crate) const SPACING: f64 = 30.0;
/// The `crs_from_grid` of a grid whose first sample is centred at (`WEST`, `NORTH`).
pub(crate) const PLACE: [f64; 6] = [WEST, SPACING, 0.0, NORTH, 0.0, -SPACING];
/// The `crs_from_grid` of a file without a georeference.
pub(crate) const NOWHERE: [f64; 6] = [0.0, 1.0, 0.0, 0.0, 0.0, -1.0];

pub(crate) const UTM_PRJ: &str = r#"PROJCS["WGS_1984_UTM_Zone_10N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",
SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],
PROJECTION["Transverse_Mercator"],PARAMETER["Central_Meridian",-123.0],UNIT["Meter",1.0]]"#;

/// Returns the bytes of an .hgt tile.
pub(crate) fn hgt_bytes(dem: &Dem) -> Vec<u8> {
    dem.heights.iter().flat_map(|height| height.to_be_bytes()).collect()
}

pub(crate) fn hgt(path: &Path, dem: &Dem) {
    std::fs::write(path, hgt_bytes(dem)).unwrap();
}

pub(crate) fn hgt_zip(path: &Path, member: &str, dem: &Dem) {
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("readme.txt", options).unwrap();
    archive.write_all(b"not this one").unwrap();
    archive.start_file(member, options).unwrap();
    archive.write_all(&hgt_bytes(dem)).unwrap();
    archive.finish().unwrap();
}

/// Writes an ESRI ASCII grid; `is_centre` gives the centre of the lower left sample instead of its corner.
pub(crate) fn ascii(path: &Path, dem: &Dem, is_centre: bool) -> [f64; 6] {
    let (word, half) = if is_centre { ("CENTER", 0.0) } else { ("CORNER", SPACING / 2.0) };
    let (x, y) = (WEST - half, NORTH - (dem.height - 1) as f64 * SPACING - half);
    let (width, height) = (dem.width, dem.height);
    let mut text = format!("NCOLS {width}\r\nnrows {height}\nXLL{word} {x}\nyll{word} {y}\nCellSize {SPACING}\n");
    text += "NODATA_value -32768\n";
    // Lines may break anywhere.
    for (index, height) in dem.heights.iter().enumerate() {
        let _ = write!(text, "{height}{}", if index % 13 == 12 { "\r\n  " } else { "\t" });
    }
    std::fs::write(path, text).unwrap();
    PLACE
}

pub(crate) fn grass(path: &Path, dem: &Dem) -> [f64; 6] {
    let (north, west) = (NORTH + SPACING / 2.0, WEST - SPACING / 2.0);
    let (south, east) = (north - dem.height as f64 * SPACING, west + dem.width as f64 * SPACING);
    let (width, height) = (dem.width, dem.height);
    let mut text =
        format!("north: {north}\nsouth: {south}\neast: {east}\nwest: {west}\nrows: {height}\ncols: {width}\n");
    for row in dem.rows() {
        let words: Vec<String> =
            row.iter().map(|&it| if it == i16::MIN { "*".to_owned() } else { it.to_string() }).collect();
        text += &(words.join(" ") + "\n");
    }
    std::fs::write(path, text).unwrap();
    PLACE
}

pub(crate) fn xyz(path: &Path, dem: &Dem) -> [f64; 6] {
    let mut text = String::from("x,y,z\n");
    for (row, heights) in dem.rows().enumerate() {
        for (column, height) in heights.iter().enumerate() {
            let (x, y) = (WEST + column as f64 * SPACING, NORTH - row as f64 * SPACING);
            let _ = writeln!(text, "{x},{y},{height}.0");
        }
    }
    std::fs::write(path, text).unwrap();
    PLACE
}

/// Writes an EHdr raster; `order` is `I` for little-endian, `M` for big-endian.
pub(crate) fn ehdr(path: &Path, dem: &Dem, order: &str) -> [f64; 6] {
    let sample = |it: &i16| if order == "I" { it.to_le_bytes() } else { it.to_be_bytes() };
    let bytes: Vec<u8> = dem.heights.iter().flat_map(sample).collect();
    std::fs::write(path, bytes).unwrap();
    let header = format!(
        "BYTEORDER {order}\nLAYOUT BIL\nNROWS {}\nNCOLS {}\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\nULXMAP {WEST}\n\
         ULYMAP {NORTH}\nXDIM {SPACING}\nYDIM {SPACING}\nNODATA -32768\n",
        dem.height, dem.width
    );
    std::fs::write(path.with_extension("hdr"), header).unwrap();
    std::fs::write(path.with_extension("prj"), UTM_PRJ).unwrap();
    PLACE
}

/// Writes a GridFloat raster with the sidecar files of the USGS.
pub(crate) fn grid_float(path: &Path, dem: &Dem) -> [f64; 6] {
    let sample = |it: &i16| if *it == i16::MIN { -9999.0 } else { f32::from(*it) }.to_le_bytes();
    std::fs::write(path, dem.heights.iter().flat_map(sample).collect::<Vec<u8>>()).unwrap();
    let (x, y) = (WEST - SPACING / 2.0, NORTH - (dem.height as f64 - 0.5) * SPACING);
    let header = format!(
        "ncols {}\nnrows {}\nxllcorner {x}\nyllcorner {y}\ncellsize {SPACING}\nNODATA_value -9999\nbyteorder LSBFIRST\n",
        dem.width, dem.height
    );
    std::fs::write(path.with_extension("hdr"), header).unwrap();
    std::fs::write(path.with_extension("prj"), "Projection UTM\nZone 10\nDatum NAD83\nUnits METERS\n").unwrap();
    PLACE
}

/// Writes an ENVI raster of three bands, the first of which has the heights; `interleave` is `bip`, `bil` or `bsq`.
pub(crate) fn envi(path: &Path, dem: &Dem, interleave: &str) -> [f64; 6] {
    let (width, height) = (dem.width, dem.height);
    let mut bytes = vec![0xee; 11];
    let band = |band: usize, height: i16| if band == 0 { height } else { 77 }.to_be_bytes();
    match interleave {
        "bip" => bytes.extend(dem.heights.iter().flat_map(|&it| (0..3).flat_map(move |index| band(index, it)))),
        "bil" => {
            bytes.extend(
                dem.rows()
                    .flat_map(|row| (0..3).flat_map(move |index| row.iter().flat_map(move |&it| band(index, it)))),
            );
        }
        _ => bytes.extend((0..3).flat_map(|index| dem.heights.iter().flat_map(move |&it| band(index, it)))),
    }
    std::fs::write(path, bytes).unwrap();
    let header = format!(
        "ENVI\ndescription = {{\n  a grid}}\nsamples = {width}\nlines = {height}\nbands = 3\nheader offset = 11\n\
         data type = 2\ninterleave = {interleave}\nbyte order = 1\ndata ignore value = -32768\n\
         map info = {{UTM, 1.5, 1.5, {WEST}, {NORTH}, {SPACING}, {SPACING}, 10, North, WGS-84, units=Meters}}\n"
    );
    std::fs::write(path.with_extension("hdr"), header).unwrap();
    PLACE
}

/// Writes DTED level 0 at 8° east, 46° north, with columns twice as far apart as rows; the file ends after `columns`.
pub(crate) fn dted(path: &Path, dem: &Dem, columns: usize) -> [f64; 6] {
    let mut header = vec![b' '; 80 + 648 + 2700];
    let mut put = |at: usize, text: &str| header[at..at + text.len()].copy_from_slice(text.as_bytes());
    put(0, "UHL10080000E0460000N06000300");
    put(47, &format!("{:04}{:04}", dem.width, dem.height));
    put(80, "DSIU");
    put(80 + 144, "WGS84");
    put(728, "ACC");
    let mut bytes = header;
    for column in 0..columns {
        let mut record = vec![0xaa, 0, 0, column as u8];
        record.extend((column as u16).to_be_bytes());
        record.extend([0, 0]);
        for row in (0..dem.height).rev() {
            let raw = match dem.at(column, row) {
                i16::MIN => 0xffff,
                height if height < 0 => 0x8000 | height.unsigned_abs(),
                height => height as u16,
            };
            record.extend(raw.to_be_bytes());
        }
        let sum: u32 = record.iter().map(|&byte| u32::from(byte)).sum();
        record.extend(sum.to_be_bytes());
        bytes.extend(record);
    }
    std::fs::write(path, bytes).unwrap();
    let (dx, dy) = (60.0 / 3600.0, 30.0 / 3600.0);
    [8.0, dx, 0.0, 46.0 + (dem.height - 1) as f64 * dy, 0.0, -dy]
}

pub(crate) fn png(path: &Path, [width, height]: [usize; 2], color: png::ColorType, depth: png::BitDepth, bytes: &[u8]) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), width as u32, height as u32);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
}

/// Writes a 16-bit PNG; no-data is 0.
pub(crate) fn png16(path: &Path, dem: &Dem) {
    let bytes: Vec<u8> = dem.heights.iter().flat_map(|&it| (it.max(0) as u16).to_be_bytes()).collect();
    png(path, [dem.width, dem.height], png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes);
}

/// Writes raw unsigned 16-bit samples; no-data is 0.
pub(crate) fn raw(path: &Path, dem: &Dem, is_big_endian: bool) {
    let sample = |&it: &i16| {
        let it = it.max(0) as u16;
        if is_big_endian { it.to_be_bytes() } else { it.to_le_bytes() }
    };
    std::fs::write(path, dem.heights.iter().flat_map(sample).collect::<Vec<u8>>()).unwrap();
}

/// Writes a terrain-RGB PNG; no-data is black.
pub(crate) fn terrain_rgb(path: &Path, dem: &Dem, is_mapbox: bool) {
    let pixel = |&it: &i16| {
        let code = match it {
            i16::MIN => 0,
            it if is_mapbox => ((i32::from(it) + 10_000) * 10) as u32,
            it => (i32::from(it) + 32_768) as u32 * 256,
        };
        [(code >> 16) as u8, (code >> 8) as u8, code as u8]
    };
    let bytes: Vec<u8> = dem.heights.iter().flat_map(pixel).collect();
    png(path, [dem.width, dem.height], png::ColorType::Rgb, png::BitDepth::Eight, &bytes);
}

/// Writes a USGS DEM in UTM zone 10 on NAD27. Columns begin above their no-data samples in the south; `line_breaks`
/// puts a line break after each record.
pub(crate) fn usgs_dem(path: &Path, dem: &Dem, line_breaks: bool) -> [f64; 6] {
    let d = |value: f64| format!("{:>24}", format!("{value:.15E}").replace('E', "D+0").replace("D+0-", "D-0"));
    let e = |value: f64| format!("{:>12}", format!("{value:.6E}").replace('E', "E+0"));
    let (east, south) = (WEST + (dem.width - 1) as f64 * SPACING, NORTH - (dem.height - 1) as f64 * SPACING);
    let mut a = format!("{:<144}{:>6}{:>6}{:>6}{:>6}", "A GRID", 1, 1, 1, 10);
    a += &d(0.0).repeat(15);
    a += &format!("{:>6}{:>6}{:>6}", 2, 2, 4);
    for [x, y] in [[WEST, south], [WEST, NORTH], [east, NORTH], [east, south]] {
        a += &(d(x) + &d(y));
    }
    a += &(d(0.0) + &d(3000.0) + &d(0.0) + &format!("{:>6}", 0));
    a += &(e(SPACING) + &e(SPACING) + &e(1.0) + &format!("{:>6}{:>6}", 1, dem.width));
    let mut records = vec![a];
    for column in 0..dem.width {
        let values: Vec<i16> = (0..dem.height).rev().map(|row| dem.at(column, row)).collect();
        let skipped = values.iter().take_while(|&&it| it == i16::MIN).count();
        let mut record = format!("{:>6}{:>6}{:>6}{:>6}", 1, column + 1, values.len() - skipped, 1);
        record += &(d(WEST + column as f64 * SPACING) + &d(south + skipped as f64 * SPACING));
        record += &(d(0.0) + &d(0.0) + &d(3000.0));
        for value in &values[skipped..] {
            if record.len() + 6 > 1024 {
                records.push(std::mem::take(&mut record));
            }
            let _ = write!(record, "{:>6}", if *value == i16::MIN { -32_767 } else { *value });
        }
        records.push(record);
    }
    let end = if line_breaks { "\n" } else { "" };
    let text: String = records.iter().map(|record| format!("{record:<1024}{end}")).collect();
    std::fs::write(path, text).unwrap();
    PLACE
}

/// The format of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Colours {
    Png,
    WebP,
}

/// Writes a picture of 8-bit colours.
pub(crate) fn colours(path: &Path, [width, height]: [usize; 2], pixels: &[[u8; 3]], format: Colours) {
    let bytes = pixels.as_flattened();
    if format == Colours::Png {
        return png(path, [width, height], png::ColorType::Rgb, png::BitDepth::Eight, bytes);
    }
    let encoder = image_webp::WebPEncoder::new(std::fs::File::create(path).unwrap());
    encoder.encode(bytes, width as u32, height as u32, image_webp::ColorType::Rgb8).unwrap();
}

/// A lossy WebP picture of 16 × 16 pixels.
#[rustfmt::skip]
pub(crate) const LOSSY_WEBP: [u8; 52] = [
    0x52, 0x49, 0x46, 0x46, 0x2c, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50, 0x56, 0x50, 0x38, 0x20,
    0x20, 0x00, 0x00, 0x00, 0x50, 0x01, 0x00, 0x9d, 0x01, 0x2a, 0x10, 0x00, 0x10, 0x00, 0x02, 0xc0,
    0x4c, 0x25, 0x00, 0x4e, 0x80, 0x37, 0xd0, 0x00, 0xfe, 0xd0, 0xca, 0x2a, 0xf5, 0x79, 0x94, 0xda,
    0x44, 0x10, 0x00, 0x00,
];

/// Writes the tiles of a folder as a PMTiles archive ("PMTiles Version 3 Specification", section 3) without
/// compression; `kind` is the number of the tiles' type.
pub(crate) fn pmtiles(path: &Path, tiles: &Path, zoom: u8, kind: u8, metadata: &str) {
    let number = |path: &Path| path.file_stem().unwrap().to_str().unwrap().parse::<u32>().unwrap();
    let inside = |path: &Path| std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>();
    let columns = inside(&tiles.join(zoom.to_string()));
    let files = columns.iter().flat_map(|column| inside(column).into_iter().map(|file| (number(column), file)));
    let id =
        |x: u32, file: &Path| pmtiles::TileId::from(pmtiles::TileCoord::new(zoom, x, number(file)).unwrap()).value();
    let mut files: Vec<(u64, Vec<u8>)> = files.map(|(x, file)| (id(x, &file), std::fs::read(&file).unwrap())).collect();
    files.sort();
    let varint = |mut value: u64, out: &mut Vec<u8>| {
        while value > 127 {
            out.push(value as u8 | 128);
            value >>= 7;
        }
        out.push(value as u8);
    };
    let (mut directory, mut last, mut offset) = (Vec::new(), 0, 0);
    varint(files.len() as u64, &mut directory);
    for (id, _) in &files {
        varint(id - last, &mut directory);
        last = *id;
    }
    files.iter().for_each(|_| varint(1, &mut directory));
    files.iter().for_each(|(_, bytes)| varint(bytes.len() as u64, &mut directory));
    for (_, bytes) in &files {
        varint(offset + 1, &mut directory);
        offset += bytes.len() as u64;
    }
    let root = 127;
    let after = root + directory.len() as u64;
    let data = after + metadata.len() as u64;
    let count = files.len() as u64;
    let mut out = b"PMTiles\x03".to_vec();
    let sections =
        [root, directory.len() as u64, after, metadata.len() as u64, data, 0, data, offset, count, count, count];
    sections.iter().for_each(|number| out.extend(number.to_le_bytes()));
    out.extend([1, 1, 1, kind, zoom, zoom]);
    out.resize(127, 0);
    out.extend(directory);
    out.extend(metadata.as_bytes());
    files.iter().for_each(|(_, bytes)| out.extend(bytes));
    std::fs::write(path, out).unwrap();
}

/// Compresses a file.
pub(crate) fn gzip(path: &Path, bytes: &[u8]) {
    let mut encoder = flate2::write::GzEncoder::new(std::fs::File::create(path).unwrap(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap();
}

/// Writes a ZIP archive of files with these names.
pub(crate) fn zip(path: &Path, members: &[(&str, &[u8])]) {
    let mut archive = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    for (name, bytes) in members {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap();
}

/// Returns a tar archive of files with these names.
pub(crate) fn tar(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = tar::Builder::new(Vec::new());
    for (name, bytes) in members {
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        archive.append_data(&mut header, name, *bytes).unwrap();
    }
    archive.into_inner().unwrap()
}

/// Writes heights as GEBCO does: rows from the south, longitudes and latitudes.
pub(crate) fn netcdf(path: &Path, dem: &Dem, format: NcWriteFormat, is_packed: bool) {
    let mut builder = NcFileBuilder::new();
    let lat = builder.add_dimension("lat", dem.height as u64).unwrap();
    let lon = builder.add_dimension("lon", dem.width as u64).unwrap();
    let chars = |text: &str| NcAttrValue::Chars(text.to_owned());
    for (name, dimension, count, first) in [("lat", lat, dem.height, 46.0), ("lon", lon, dem.width, 8.0)] {
        let variable = builder.add_variable::<f64>(name, &[dimension]).unwrap();
        builder.add_variable_attribute(variable, "units", chars("degrees")).unwrap();
        let values: Vec<f64> = (0..count).map(|index| first + index as f64 / 240.0).collect();
        builder.write_variable(variable, &values).unwrap();
    }
    let flags = builder.add_variable::<i8>("tid", &[lat, lon]).unwrap();
    builder.write_variable(flags, &vec![7_i8; dem.heights.len()]).unwrap();
    let heights = builder.add_variable::<i16>("elevation", &[lat, lon]).unwrap();
    builder.add_variable_attribute(heights, "_FillValue", NcAttrValue::Shorts(vec![i16::MIN])).unwrap();
    builder.add_variable_attribute(heights, "units", chars("m")).unwrap();
    if is_packed {
        builder.add_variable_attribute(heights, "scale_factor", NcAttrValue::Doubles(vec![1.0])).unwrap();
        builder.set_variable_chunking(heights, vec![16, 16]).unwrap();
        builder.set_variable_deflate(heights, Some(4), true).unwrap();
    }
    let from_south: Vec<i16> = dem.rows().rev().flatten().copied().collect();
    builder.write_variable(heights, &from_south).unwrap();
    std::fs::write(path, builder.to_vec(NcWriteOptions { format }).unwrap().1).unwrap();
}
