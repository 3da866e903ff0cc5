//! Tests `render --sheets`: the sheets, laid over each other, are the poster.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

#[path = "../src/tests/common/program.rs"]
mod program;

use std::path::Path;

use hachure::file::imprint::{self, Notes};
use hachure::file::png::{Picture, read_rgba8};
use hachure::internals::{Place, Sheets, Wish};
use hachure::internals::{SheetWriter, sheet_path};
use kurbo::{BezPath, ParamCurve, ParamCurveArclen};
use program::full;

const MM_PER_INCH: f64 = 25.4;

/// Writes the DEM `hill.asc`.
fn write_hill(folder: &Path) {
    let mut text = "ncols 96\nnrows 96\nxllcorner 0\nyllcorner 0\ncellsize 30\n".to_owned();
    for row in 0..96 {
        let height_m = |column: i32| {
            let (x, y) = (f64::from(column) / 14.0, f64::from(row) / 17.0);
            400.0 + 300.0 * (x.sin() * y.cos()) + 60.0 * (3.1 * x + y).sin()
        };
        let heights: Vec<String> = (0..96).map(|column| format!("{:.2}", height_m(column))).collect();
        text += &(heights.join(" ") + "\n");
    }
    hachure::file::atomic::write(&folder.join("hill.asc"), text.as_bytes()).unwrap();
}

/// Windows of sheets along one axis of a poster, computed from what `--help` says.
struct Axis {
    inset: usize,
    window: usize,
    step: usize,
    poster: usize,
}

impl Axis {
    fn new(paper_mm: f64, poster: usize, dpi: f64, overlap_mm: f64, margin_mm: f64) -> Self {
        let px = |mm: f64| (mm / MM_PER_INCH * dpi).round() as usize;
        // Six millimetres are for crop marks.
        let inset = px(margin_mm + 6.0);
        let window = px(paper_mm) - 2 * inset;
        Self { inset, window, step: window - px(overlap_mm), poster }
    }

    fn count(&self) -> usize {
        1 + self.poster.saturating_sub(self.window).div_ceil(self.step)
    }

    fn part(&self, at: usize) -> [usize; 2] {
        [at * self.step, (at * self.step + self.window).min(self.poster)]
    }
}

fn pixel(picture: &Picture, x: usize, y: usize) -> [u8; 3] {
    let at = 4 * (y * picture.width as usize + x);
    [picture.rgba[at], picture.rgba[at + 1], picture.rgba[at + 2]]
}

/// Counts pixels of sheets that differ from those of the poster, and how often each pixel of the poster appears.
fn unlike(poster: &Picture, folder: &Path, [across, down]: [&Axis; 2], shift: usize) -> (usize, Vec<u8>) {
    let mut met = vec![0_u8; poster.width as usize * poster.height as usize];
    let mut wrong = 0;
    for row in 0..down.count() {
        for column in 0..across.count() {
            let place = Place { column: column as u32, row: row as u32 };
            let sheet = read_rgba8(&sheet_path(&folder.join("poster.png"), place)).unwrap();
            let ([x0, x1], [y0, y1]) = (across.part(column), down.part(row));
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                let on_sheet = pixel(&sheet, x - x0 + across.inset + shift, y - y0 + down.inset);
                wrong += usize::from(on_sheet != pixel(poster, x, y));
                met[y * poster.width as usize + x] += 1;
            }
        }
    }
    (wrong, met)
}

#[test]
fn sheets_are_the_poster_pixel_for_pixel() {
    let folder = tempfile::tempdir().unwrap();
    write_hill(folder.path());
    let style = if full() { "crosshatch" } else { "lsa" };
    let drawing = format!("hill.asc --style {style} --paper 300x200 --dpi 60");
    let said = program::run(folder.path(), &format!("{drawing} --sheets a6 --sheets-overlap 12 -o poster.png"));
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let said = String::from_utf8(said.stdout).unwrap();
    let expected = "9 sheets of 148x105 mm, poster-A1.png to poster-C3.png: 3 rows of 3, overlapping by 12 mm";
    assert_eq!(said.trim_end(), expected);
    let poster = read_rgba8(&folder.path().join("poster.png")).unwrap();
    let across = Axis::new(148.0, poster.width as usize, 60.0, 12.0, 6.0);
    let down = Axis::new(105.0, poster.height as usize, 60.0, 12.0, 6.0);
    assert_eq!([across.count(), down.count()], [3, 3]);
    let (wrong, met) = unlike(&poster, folder.path(), [&across, &down], 0);
    assert_eq!(wrong, 0);
    assert!(met.iter().all(|times| *times > 0) && met.contains(&4), "every pixel must appear, and corners four times");
    // Planted: sheets that are a pixel too far to the right.
    assert!(unlike(&poster, folder.path(), [&across, &down], 1).0 > met.len() / 50);
    // A sheet is as large as its paper, and has the imprint of the poster with its name.
    let sheet = read_rgba8(&folder.path().join("poster-B2.png")).unwrap();
    assert_eq!([sheet.width, sheet.height], [350, 248]);
    let text = |name: &str| imprint::read(&folder.path().join(name)).unwrap();
    assert_eq!(text("poster-B2.png"), text("poster.png") + "# sheet B2\n");
    // Crop marks are in the strip between the printable area's border and the window, and nowhere else.
    let dark = |x: usize, y: usize| pixel(&sheet, x, y)[0] < 200;
    let strip = 14..across.inset;
    assert!((0..350).any(|x| strip.clone().any(|y| dark(x, y))));
    assert!((0..350).all(|x| (0..14).chain(234..248).all(|y| !dark(x, y))));
    // Without sheets the poster is the same.
    program::draw(folder.path(), &format!("{drawing} -o alone.png"));
    assert!(read_rgba8(&folder.path().join("alone.png")).unwrap() == poster);
}

#[test]
fn bands_of_any_height_make_the_same_sheets() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (431_usize, 377_usize);
    let rgba: Vec<u8> = (0..width * height * 4).map(|i| (i.wrapping_mul(i) / 7 + i / 13) as u8).collect();
    let poster = Picture { width: width as u32, height: height as u32, rgba };
    let wish = Wish { paper_mm: [80.0, 60.0], overlap_mm: 5.0, margin_mm: 2.0 };
    let sheets = Sheets::new([width as f64, height as f64], 3.0, true, &wish).unwrap();
    let path = folder.path().join("poster.png");
    let [across, down] = if sheets.paper[0] > sheets.paper[1] { [80.0, 60.0] } else { [60.0, 80.0] };
    let across = Axis::new(across, width, 3.0 * MM_PER_INCH, 5.0, 2.0);
    let down = Axis::new(down, height, 3.0 * MM_PER_INCH, 5.0, 2.0);
    for band in [1, 100, 7, height].into_iter().take(if full() { 4 } else { 2 }) {
        let mut writer = SheetWriter::new(sheets, &path, Notes::default());
        poster.rgba.chunks(band * width * 4).for_each(|rows| writer.write_rows(rows).unwrap());
        let ended = writer.end().unwrap();
        assert!(!sheet_path(&path, Place { column: 0, row: 0 }).exists(), "files must get their names last");
        ended.commit().unwrap();
        assert_eq!(unlike(&poster, folder.path(), [&across, &down], 0).0, 0, "bands of {band} rows");
        std::fs::read_dir(folder.path())
            .unwrap()
            .for_each(|entry| std::fs::remove_file(entry.unwrap().path()).unwrap());
    }
    // A missing row is an error, and no file remains.
    let mut writer = SheetWriter::new(sheets, &path, Notes::default());
    writer.write_rows(&poster.rgba[width * 4..]).unwrap();
    assert!(writer.end().is_err_and(|error| error.to_string().contains("rows are missing")));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Returns points along the paths of an SVG, a tenth of a millimetre apart, without those of crop marks, and its size
/// in millimetres.
fn points(path: &Path) -> (Vec<kurbo::Point>, [f64; 2]) {
    let text = std::fs::read_to_string(path).unwrap();
    let value = |text: &str, key: &str| -> f64 {
        let (_, rest) = text.split_once(&format!(" {key}=\"")).unwrap();
        rest.split_once("mm\"").unwrap().0.parse().unwrap()
    };
    let size = ["width", "height"].map(|key| value(&text, key));
    let drawing = text.split("<g id=\"sheet-marks\"").next().unwrap();
    let mut points = Vec::new();
    for line in drawing.lines().filter(|line| line.starts_with("<path")) {
        let (_, path) = line.split_once(" d=\"").unwrap();
        for segment in BezPath::from_svg(path.split_once('"').unwrap().0).unwrap().segments() {
            let count = (segment.arclen(1e-3) / 0.1).ceil().max(1.0) as usize;
            points.extend((0..count).map(|i| segment.eval((i as f64 + 0.5) / count as f64)));
        }
    }
    (points, size)
}

/// Returns the share of points that are farther than 0.08 mm from all of the others.
fn alone(points: &[kurbo::Point], others: &[kurbo::Point]) -> f64 {
    let cell = |point: &kurbo::Point| [(point.x / 0.1).floor() as i64, (point.y / 0.1).floor() as i64];
    let mut cells = std::collections::HashMap::<[i64; 2], Vec<kurbo::Point>>::new();
    others.iter().for_each(|other| cells.entry(cell(other)).or_default().push(*other));
    let is_alone = |point: &&kurbo::Point| {
        let [x, y] = cell(point);
        let near = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
        !near.filter_map(|cell| cells.get(&cell)).flatten().any(|other| other.distance(**point) < 0.08)
    };
    points.iter().filter(is_alone).count() as f64 / points.len().max(1) as f64
}

#[test]
fn the_paths_of_sheets_are_those_of_the_poster() {
    let folder = tempfile::tempdir().unwrap();
    write_hill(folder.path());
    program::draw(folder.path(), "hill.asc --style strokes --paper 300x200 --dpi 60 --margin 5 --sheets a6 -o p.svg");
    let (poster, size) = points(&folder.path().join("p.svg"));
    assert!(size == [300.0, 200.0] && poster.len() > 3000, "{size:?}, {} points", poster.len());
    // Windows of A6 in landscape orientation, and steps, in millimetres.
    let (window, step) = ([124.0, 81.0], [114.0, 71.0]);
    let mut all = Vec::new();
    for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
        let name = sheet_path(&folder.path().join("p.svg"), Place { column, row });
        let (on_sheet, size) = points(&name);
        assert_eq!(size, [148.0, 105.0]);
        let begin = [f64::from(column) * step[0], f64::from(row) * step[1]];
        let inside = |point: &kurbo::Point| {
            point.x >= 11.99 && point.x <= 12.01 + window[0] && point.y >= 11.99 && point.y <= 12.01 + window[1]
        };
        assert!(on_sheet.iter().all(inside), "{}", name.display());
        all.extend(on_sheet.iter().map(|point| *point + (begin[0] - 12.0, begin[1] - 12.0)));
    }
    let unlike = |all: &[kurbo::Point]| alone(&poster, all).max(alone(all, &poster));
    println!("{} points of the poster, {} of sheets, {:.4} alone", poster.len(), all.len(), unlike(&all));
    assert!(unlike(&all) < 0.002, "{}", unlike(&all));
    assert!(all.len() > poster.len(), "overlaps must be there twice");
    // Planted: sheets that are a pixel, 0.4 mm, too far down; and a missing sheet.
    let moved: Vec<kurbo::Point> = all.iter().map(|point| *point + (0.0, 0.4)).collect();
    assert!(unlike(&moved) > 0.3, "{}", unlike(&moved));
    let one_less: Vec<kurbo::Point> = all.iter().copied().filter(|point| point.x < 114.0 || point.y > 71.0).collect();
    assert!(unlike(&one_less) > 0.02, "{}", unlike(&one_less));
}

#[test]
fn what_cannot_be_cut_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    write_hill(folder.path());
    for (arguments, words) in [
        ("-o a.png --sheets a4", "has no size in millimetres; add --paper or --dpi"),
        ("-o a.svg --style strokes --sheets a4", "has no size in millimetres"),
        ("-o a.exr --dpi 100 --sheets a4", "--sheets: can only cut a drawing in a .png or .svg"),
        ("-o a.png --dpi 100 --sheets a9", "--sheets \"a9\": it must be a0"),
        ("-o a.png --dpi 100 --sheets-overlap 3", "--sheets-overlap: requires --sheets"),
        ("-o a.png --dpi 100 --sheets a4 --sheets-overlap 200", "leave no room"),
        ("-o a.png --dpi 20 --sheets 60x60mm", "the limit is 400"),
        ("-o a.png --dpi 100 --sheets a4 --sheets-margin=-1", "--sheets-margin"),
    ] {
        let output = program::run(folder.path(), &format!("hill.asc {arguments}"));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.trim_end().lines().count() == 1, "{arguments}: {said}");
        assert!(said.contains(words), "{arguments}: {said}");
        assert!(!folder.path().join("a.png").exists());
    }
    // If one sheet cannot be named, the poster is not named either, and nothing remains.
    std::fs::create_dir_all(folder.path().join("p-A1.png/full")).unwrap();
    let output = program::run(folder.path(), "hill.asc --size 64x36 --dpi 20 --sheets a6 -o p.png");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && said.contains("p-A1.png"), "{said}");
    assert_eq!(said.lines().filter(|line| !line.starts_with(" WARN")).count(), 1, "{said}");
    let names = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    // Marks of the default style may be in the cache.
    names.retain(|name| name != "cache");
    assert_eq!(names, ["hill.asc", "p-A1.png"]);
    // A sheet that would replace an input.
    std::fs::rename(folder.path().join("hill.asc"), folder.path().join("q-A1.png")).unwrap();
    let output = program::run(folder.path(), "q-A1.png --size 64x36 --dpi 20 --sheets a6 -o q.png");
    assert!(String::from_utf8(output.stderr).unwrap().contains("is the input"));
}
