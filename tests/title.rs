//! Tests `render --title`: the title block below a picture, in pixels and in paths.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

#[path = "../src/tests/common/program.rs"]
mod program;

use std::path::Path;

use hachure::file::imprint;
use hachure::file::png::{Picture, read_rgba8};
use kurbo::{BezPath, ParamCurve, ParamCurveArclen};
use program::full;

/// Returns a folder with `hill.asc`: 96 × 96 samples of 30 m.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "ncols 96\nnrows 96\nxllcorner 0\nyllcorner 0\ncellsize 30\n".to_owned();
    for row in 0..96 {
        let height_m = |column: i32| {
            let (x, y) = (f64::from(column) / 14.0, f64::from(row) / 17.0);
            400.0 + 300.0 * (x.sin() * y.cos()) + 60.0 * (3.1 * x + y).sin()
        };
        let heights: Vec<String> = (0..96).map(|column| format!("{:.2}", height_m(column))).collect();
        text += &(heights.join(" ") + "\n");
    }
    hachure::file::atomic::write(&folder.path().join("hill.asc"), text.as_bytes()).unwrap();
    folder
}

/// Draws with arguments and a title, which may contain blanks. Returns the standard error.
fn draw(folder: &Path, arguments: &str, title: &str) -> String {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hachure"))
        .arg("render")
        .args(arguments.split_whitespace())
        .args(["--title", title])
        .current_dir(folder)
        .env("HACHURE_CACHE", folder.join("cache"))
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {said}");
    said
}

fn read(folder: &Path, name: &str) -> Picture {
    read_rgba8(&folder.join(name)).unwrap()
}

fn red(picture: &Picture, x: usize, y: usize) -> u8 {
    picture.rgba[4 * (y * picture.width as usize + x)]
}

/// Height of the title block of a picture without a margin, at 96 dots per inch, in pixels.
const FOOT: usize = 72;

#[test]
fn a_map_with_a_title_is_the_map_above_it() {
    let folder = place();
    let folder = folder.path();
    // The paper is not white, and its grain must continue in the title block.
    for style in ["ink", "wash"].into_iter().take(if full() { 2 } else { 1 }) {
        program::draw(folder, &format!("hill.asc --map --size 400x300 --style {style} -o map.png"));
        draw(folder, &format!("hill.asc --map --size 400x372 --style {style} -o titled.png"), "Hill");
        let (map, titled) = (read(folder, "map.png"), read(folder, "titled.png"));
        let world = |name: &str| -> Vec<f64> {
            let text = std::fs::read_to_string(folder.join(name)).unwrap();
            text.lines().map(|line| line.parse().unwrap()).collect()
        };
        let (own, other) = (world("map.pgw"), world("titled.pgw"));
        assert!(own.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-6), "{style}: {own:?} {other:?}");
        // The eye is at another height, which changes normals slightly, so a few pixels may differ.
        let unlike = |shift: usize| {
            let pixels = (0..300).flat_map(|y| (0..396).map(move |x| (x, y)));
            pixels.filter(|(x, y)| red(&map, *x, *y).abs_diff(red(&titled, x + shift, *y)) > 24).count()
        };
        println!("{style}: {} of 120000 pixels differ, planted {}", unlike(0), unlike(2));
        assert!(unlike(0) < 1500 && unlike(2) > 3 * unlike(0).max(500), "{style}");
        let foot = (300..372).flat_map(|y| (0..400).map(move |x| (x, y)));
        let bare = foot.clone().filter(|(x, y)| red(&titled, *x, *y) > 190).count();
        assert!(bare > 24_000 && bare < 28_500, "{style}: paper and letters, {bare}");
    }
}

/// Width of the edge of a framed picture at 96 dots per inch, in pixels.
const FRAME: usize = 32;

/// Returns the numbers of a world file.
fn world_file(folder: &Path, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    text.lines().map(|line| line.parse().unwrap()).collect()
}

#[test]
fn a_framed_map_is_the_map_inside() {
    let folder = place();
    let folder = folder.path();
    program::draw(folder, "hill.asc --map --size 400x300 --style ink -o map.png");
    program::draw(folder, "hill.asc --map --map-frame --size 464x364 --style ink -o framed.png");
    let (map, framed) = (read(folder, "map.png"), read(folder, "framed.png"));
    let (own, other) = (world_file(folder, "map.pgw"), world_file(folder, "framed.pgw"));
    // East and north of the first pixel are the last two numbers.
    let corner = [own[4] - FRAME as f64 * own[0], own[5] - FRAME as f64 * own[3]];
    assert!((own[0] - other[0]).abs() < 1e-6 && (corner[0] - other[4]).abs() < 1e-3, "{own:?} {other:?}");
    assert!((corner[1] - other[5]).abs() < 1e-3, "{own:?} {other:?}");
    let unlike = |shift: usize| {
        let pixels = (8..292).flat_map(|y| (8..390).map(move |x| (x, y)));
        pixels.filter(|(x, y)| red(&map, *x, *y).abs_diff(red(&framed, x + FRAME + shift, y + FRAME)) > 24).count()
    };
    println!("{} pixels differ, planted {}", unlike(0), unlike(2));
    assert!(unlike(0) < 1500 && unlike(2) > 3 * unlike(0).max(500), "{} {}", unlike(0), unlike(2));
    // Between the border and the line around the sheet there are coordinates on paper.
    let depth = |x: usize, y: usize| x.min(y).min(463 - x).min(363 - y);
    let between =
        (0..364).flat_map(|y| (0..464).map(move |x| (x, y))).filter(|(x, y)| (13..29).contains(&depth(*x, *y)));
    let dark = between.clone().filter(|(x, y)| red(&framed, *x, *y) < 160).count();
    let all = between.count();
    assert!(dark > 120 && dark < all / 10, "{dark} of {all} pixels are letters");
    program::draw(folder, "hill.asc --map --map-frame --size 464x364 --style ink -o framed.svg");
    let lines = layer_points(&folder.join("framed.svg"), "frame");
    let letters = lines.iter().filter(|at| {
        let [x, y] = [at.x, at.y].map(|at| at.max(0.0) as usize);
        (13..29).contains(&depth(x.min(463), y.min(363))) && red(&framed, x.min(463), y.min(363)) < 200
    });
    let letters = letters.count();
    assert!(letters > 100, "{letters} of {} points of the frame's lines", lines.len());
    // The picture says how it was drawn.
    let text = imprint::read(&folder.join("framed.png")).unwrap();
    assert!(text.starts_with("version = 9\n") && text.contains("frame = true"), "{text}");
    if full() {
        program::draw(folder, "--like framed.png -o again.png");
        assert!(read(folder, "framed.png") == read(folder, "again.png"));
    }
}

#[test]
fn a_framed_map_on_paper_has_a_round_scale() {
    let folder = place();
    let folder = folder.path();
    let scale = |frame: &str| {
        program::draw(
            folder,
            &format!("hill.asc --map {frame} --paper a6 --dpi 96 --style plain -o a.png --overwrite"),
        );
        world_file(folder, "a.pgw")[0] * 1000.0 * 96.0 / 25.4
    };
    // The middle of the land, 96 samples of 30 m, is in the middle of the map, which is above the title block.
    draw(folder, "hill.asc --map --map-frame --paper a6 --dpi 96 --style plain -o t.png", "Hill");
    let (place, size) = (world_file(folder, "t.pgw"), read(folder, "t.png"));
    let middle = [0.5 * f64::from(size.width) - 0.5, 0.5 * (f64::from(size.height) - FOOT as f64) - 0.5];
    let found = [place[4] + middle[0] * place[0], place[5] + middle[1] * place[3]];
    let off_px = found.map(|at| (at - 1440.0).abs() / place[0]);
    assert!(off_px[0] < 1.5 && off_px[1] < 1.5, "{found:?}");
    for (arguments, cause) in [
        ("hill.asc --map-frame -o b.png", "--map-frame: frames a map; add --map"),
        ("hill.asc --map --map-frame -o b.geojson", "--map-frame: a .geojson has no frame"),
        ("hill.asc --map-frame --path tour -o b.mp4", "--map-frame: frames a map, and b.mp4 is a film"),
        ("hill.asc --map --map-frame --size 100x400 -o b.png", "it must have at least 128x128 px"),
        ("hill.asc --map-frame -o b.stl", "--map-frame: does not apply to a mesh"),
    ] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_hachure"))
            .arg("render")
            .args(arguments.split_whitespace())
            .current_dir(folder)
            .env("HACHURE_CACHE", folder.join("cache"))
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(cause), "{arguments}: {said}");
    }
    let digits = |scale: f64| scale / 10.0_f64.powf(scale.log10().floor());
    let is_round = |scale: f64| {
        [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5, 10.0]
            .iter()
            .any(|round| (digits(scale) / round - 1.0).abs() < 1e-6)
    };
    let [framed, planted] = [scale("--map-frame"), scale("")];
    assert!(is_round(framed) && !is_round(planted) && framed > planted, "1 : {framed}, without a frame 1 : {planted}");
}

#[test]
fn a_title_is_drawn_again_by_like() {
    let folder = place();
    let folder = folder.path();
    let style = if full() { "pen" } else { "lsa" };
    let view = format!("hill.asc --size 320x240 --camera=0,-1600,+300,4,-9,50 --style {style} --set tone.fit=false");
    draw(folder, &format!("{view} --dpi 120 -o a.png"), "Hügel – 1");
    let text = imprint::read(&folder.join("a.png")).unwrap();
    assert!(text.starts_with("version = 3\n") && text.contains("title = \"Hügel – 1\""), "{text}");
    program::draw(folder, "--like a.png -o b.png");
    assert!(read(folder, "a.png") == read(folder, "b.png"));
    draw(folder, "--like a.png -o c.png", "Hügel – 2");
    let (a, c) = (read(folder, "a.png"), read(folder, "c.png"));
    let unlike = (0..320 * 240).filter(|i| a.rgba[4 * i..4 * i + 4] != c.rgba[4 * i..4 * i + 4]).count();
    assert!(unlike > 5 && unlike < 400, "planted: another digit must change a few pixels, not {unlike}");
    // Without a title the imprint has the version that older programs can read.
    program::draw(folder, "hill.asc --style strokes --size 64x36 -o d.png");
    assert!(imprint::read(&folder.join("d.png")).unwrap().starts_with("version = 1\n"));
}

/// Returns points along the paths of a layer of an SVG, in its unit.
fn layer_points(path: &Path, id: &str) -> Vec<kurbo::Point> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut points = Vec::new();
    for layer in text.split("<g id=\"").skip(1).filter(|layer| layer.starts_with(id)) {
        let paths = layer.split_once("</g>").unwrap().0.lines().filter(|line| line.starts_with("<path"));
        for line in paths {
            let (_, path) = line.split_once(" d=\"").unwrap();
            for segment in BezPath::from_svg(path.split_once('"').unwrap().0).unwrap().segments() {
                let count = (segment.arclen(1e-3) / 0.5).ceil().max(1.0) as usize;
                points.extend((0..count).map(|i| segment.eval((i as f64 + 0.5) / count as f64)));
            }
        }
    }
    points
}

#[test]
fn paths_are_where_the_pixels_are() {
    let folder = place();
    let folder = folder.path();
    for pens in ["", " --pens 2"].into_iter().take(if full() { 2 } else { 1 }) {
        let view = "hill.asc --map --size 400x372 --style strokes";
        draw(folder, &format!("{view} -o a.png"), "Hill of waves");
        draw(folder, &format!("{view}{pens} -o a.svg"), "Hill of waves");
        let picture = read(folder, "a.png");
        let points = layer_points(&folder.join("a.svg"), "title");
        assert!(points.len() > 600, "{pens}: {} points", points.len());
        let bare = |shift: f64| {
            let at = |point: &&kurbo::Point| {
                let [x, y] = [point.x, point.y + shift].map(|at| at.clamp(0.0, 399.0) as usize);
                let y = y.min(371);
                red(&picture, x, y) > 215
            };
            points.iter().filter(at).count() as f64 / points.len() as f64
        };
        println!("pens {pens:?}: {:.4} of the letters' paths on bare paper, moved by 2 px {:.4}", bare(0.0), bare(2.0));
        assert!(bare(0.0) < 0.03, "{}", bare(0.0));
        assert!(bare(2.0) > 0.15, "planted letters moved by two pixels were not detected: {}", bare(2.0));
        // No line of the map extends into the title block.
        for id in ["border", "contour", "heights"] {
            let lowest = layer_points(&folder.join("a.svg"), id).iter().map(|at| at.y).fold(0.0, f64::max);
            assert!(lowest <= (372 - FOOT) as f64 + 1.0, "{id}: {lowest}");
        }
    }
}

/// Draws with arguments that are wrong, and returns the line that says so.
fn refusal(folder: &Path, arguments: &str) -> String {
    let output = program::run(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && said.trim_end().lines().count() == 1, "{arguments}: {said}");
    said
}

#[test]
fn a_map_has_its_scale() {
    let folder = place();
    let folder = folder.path();
    let hill = if full() { "hill.asc --style ink" } else { "hill.asc --style plain" };
    // A pixel is 0.2 mm on paper. In a frame and with a title the middle of the map is above the title block.
    let foot = FOOT as f64 * 127.0 / 96.0;
    for (arguments, scale, middle, foot) in [
        ("--map=100,-50 --map-scale 12345", 12_345.0, Some([1540.0, 1390.0]), 0.0),
        ("--map --map-scale 1:12500 --map-frame --title x", 12_500.0, Some([1440.0, 1440.0]), foot),
        // Planted: the width of the land.
        ("--map", 0.0, None, 0.0),
    ] {
        program::draw(folder, &format!("{hill} {arguments} --size 600x500 --dpi 127 -o a.png --overwrite"));
        let place = world_file(folder, "a.pgw");
        let found = place[0] * 1000.0 / 0.2;
        let Some(middle) = middle else {
            assert!((found / 12_345.0 - 1.0).abs() > 1e-3 && (found / 12_500.0 - 1.0).abs() > 1e-3, "1 : {found}");
            continue;
        };
        assert!((found / scale - 1.0).abs() < 1e-9 && (place[3] / -place[0] - 1.0).abs() < 1e-9, "1 : {found}");
        // The world file is of the middle of the first pixel, and the foot has a whole number of pixels.
        let [x, y] = [place[4] + 299.5 * place[0], place[5] + (249.5 - 0.5 * foot) * place[3]];
        assert!((x - middle[0]).abs() < 1e-6 && (y - middle[1]).abs() < 0.6 * place[0], "{arguments}: {x}, {y}");
        program::draw(folder, "--like a.png -o b.png --overwrite");
        assert!(read(folder, "a.png") == read(folder, "b.png") && place == world_file(folder, "b.pgw"));
    }
    for (arguments, words) in [
        ("--map=1,2,300 --map-scale 5000 --dpi 96", "follows from its scale, and --map has a width of 300 m"),
        ("--map --map-scale 5000", "--map-scale: b.png has no size in millimetres; add --paper or --dpi"),
        ("--map-scale 5000 --dpi 96", "--map-scale: is the scale of a map; add --map"),
        (
            "--map=1,2 --dpi 96",
            "--map=1,2: a width in metres is missing, or the scale; write --map=1,2,WIDTH or add --map-scale",
        ),
        ("--map --map-scale 0 --dpi 96", "such as 50000 or 1:50000"),
    ] {
        let said = refusal(folder, &format!("hill.asc {arguments} -o b.png"));
        assert!(said.contains(words), "{arguments}: {said}");
    }
}

#[test]
fn paper_has_the_orientation_of_the_land() {
    let folder = place();
    let folder = folder.path();
    let mut tall = "ncols 20\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 30\n".to_owned();
    for row in 0..40 {
        let heights: Vec<String> = (0..20).map(|column| format!("{}", 3 * row + (column * column) % 17)).collect();
        tall += &(heights.join(" ") + "\n");
    }
    hachure::file::atomic::write(&folder.join("tall.asc"), tall.as_bytes()).unwrap();
    let is_upright = |arguments: &str| {
        program::draw(folder, &format!("{arguments} --paper a6 --dpi 60 --style plain -o a.png --overwrite"));
        let size = read(folder, "a.png");
        size.height > size.width
    };
    assert!(is_upright("tall.asc --map") && is_upright("tall.asc --map --portrait"));
    assert!(is_upright("tall.asc --map --map-scale 15000"));
    assert!(!is_upright("tall.asc --map --landscape") && !is_upright("tall.asc --map=0,0,300"));
    assert!(!is_upright("tall.asc"), "a view is as wide as a camera's");
    // Square land is larger on lying paper unless a title block takes some of its height.
    assert!(!is_upright("hill.asc --map") && is_upright("hill.asc --map --title x"));
}

#[test]
fn credits_are_a_line_of_the_title_block() {
    let folder = place();
    let folder = folder.path();
    let dark = |picture: &Picture| (0..picture.rgba.len() / 4).filter(|i| picture.rgba[4 * i] < 190).count();
    program::draw(folder, "hill.asc --map --size 500x400 --style plain --title x -o a.png");
    program::draw(folder, "hill.asc --map --size 500x413 --style plain --title x --credits Heights:nobody -o b.png");
    let (a, b) = (read(folder, "a.png"), read(folder, "b.png"));
    // The map is the same; only letters are added.
    let added = dark(&b) as f64 - dark(&a) as f64;
    assert!(added > 60.0 && added < 600.0, "{added}");
    program::draw(folder, "--like b.png -o c.png");
    assert!(read(folder, "c.png") == b);
    let text = imprint::read(&folder.join("b.png")).unwrap();
    assert!(text.starts_with("version = 10\n") && text.contains("credits = \"Heights:nobody\""), "{text}");
    assert!(refusal(folder, "hill.asc --credits x -o d.png").contains("--credits: are part of the title block"));
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hachure"))
        .args(["render", "hill.asc", "--title", "x", "--credits", " ", "-o", "d.png"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(String::from_utf8(output.stderr).unwrap().contains("--credits: the text is empty"));
}

#[test]
fn a_legend_has_the_inks_of_what_is_drawn() {
    let folder = place();
    let folder = folder.path();
    let view = "hill.asc --map --size 700x500 --title x --legend --style ink";
    program::draw(folder, &format!("{view} --set drainage.ink=#ff0000 -o b.png"));
    // Streams are thinned out until there are none.
    program::draw(folder, &format!("{view} --set drainage.ink=#ff0000 --set drainage.spacing_px=1000 -o c.png"));
    let reddish = |name: &str, rows: std::ops::Range<usize>| {
        let picture = read(folder, name);
        let pixels = rows.flat_map(|y| (0..700).map(move |x| 4 * (y * 700 + x)));
        pixels.filter(|i| picture.rgba[*i] > 120 && picture.rgba[i + 1] < picture.rgba[*i] / 2).count()
    };
    let foot = 500 - FOOT - 10 - 42..500;
    let map = 0..500 - FOOT - 10 - 42;
    assert!(reddish("b.png", map.clone()) > 200 && reddish("b.png", foot.clone()) > 15);
    if full() {
        program::draw(folder, &format!("{view} -o a.png"));
        assert!(reddish("a.png", foot.clone()) == 0, "the colour of streams is that of the style");
    }
    let none = [reddish("c.png", map), reddish("c.png", foot)];
    assert_eq!(none, [0, 0], "planted: without streams there is no entry");
    // Vector drawings have the same samples.
    program::draw(folder, &format!("{view} --set drainage.ink=#ff0000 -o b.svg"));
    let text = std::fs::read_to_string(folder.join("b.svg")).unwrap();
    let layers = text.split("<g id=\"legend-").skip(1).map(|layer| layer.split_once("</g>").unwrap().0);
    assert!(layers.clone().count() >= 3 && layers.clone().any(|layer| layer.contains("stroke=\"#ff0000\"")));
    assert!(layers.clone().any(|layer| layer.contains("stroke=\"none\"")), "names are filled");
    if full() {
        program::draw(folder, "--like b.png -o d.png");
        assert!(read(folder, "d.png") == read(folder, "b.png"));
    }
    assert!(refusal(folder, "hill.asc --legend -o d.png").contains("--legend: is part of the title block"));
}

#[test]
fn typefaces_are_filled_and_pens_draw_strokes() {
    let folder = place();
    let folder = folder.path();
    let faces = [("serif", true), ("strokes", false), ("sans", true), ("capitals", true)];
    let style = if full() { "pen" } else { "strokes" };
    for (face, filled) in faces.into_iter().take(if full() { 4 } else { 2 }) {
        for (ending, pens) in [("svg", ""), ("svg", "--pens 1"), ("pdf", "")] {
            // Pens and PDF are tried with one typeface.
            if face != "serif" && (ending == "pdf" || !pens.is_empty()) {
                continue;
            }
            let view = format!("hill.asc --map --size 500x372 --style {style} --set paper.typeface={face} {pens}");
            draw(folder, &format!("{view} -o a.{ending}"), "Zürich");
            if ending == "svg" {
                let text = std::fs::read_to_string(folder.join("a.svg")).unwrap();
                let fills = text.matches("stroke=\"none\" d=").count();
                assert_eq!(fills > 5, filled && pens.is_empty(), "{face} {pens}: {fills} areas");
            }
        }
    }
    // The areas of the drawing are where the picture is dark.
    let view = "hill.asc --map --size 400x372 --style strokes --set paper.typeface=serif";
    draw(folder, &format!("{view} -o b.png"), "Hill of waves");
    draw(folder, &format!("{view} -o b.svg"), "Hill of waves");
    let (picture, text) = (read(folder, "b.png"), std::fs::read_to_string(folder.join("b.svg")).unwrap());
    let paths: Vec<BezPath> = text
        .lines()
        .filter(|line| line.contains("stroke=\"none\" d="))
        .map(|line| BezPath::from_svg(line.split_once(" d=\"").unwrap().1.split_once('"').unwrap().0).unwrap())
        .collect();
    // The title is the large text at the left, without the small one below it.
    let rows = 372 - FOOT + 12..372 - FOOT + 46;
    let unlike = |shift: f64| {
        let pixels = rows.clone().flat_map(|y| (17..180).map(move |x| (x, y)));
        let count = |(x, y): (usize, usize)| {
            let at = kurbo::Point::new(x as f64 + 0.5 + shift, y as f64 + 0.5);
            let is_inside = paths.iter().any(|path| kurbo::Shape::winding(path, at) != 0);
            let level = red(&picture, x, y);
            usize::from(if is_inside { level > 215 } else { level < 90 })
        };
        pixels.map(count).sum::<usize>()
    };
    let found = [unlike(0.0), unlike(2.0)];
    assert!(found[0] < 12 && found[1] > 150, "{found:?} pixels unlike the areas; planted: moved by 2 px");
}

#[test]
fn what_a_title_cannot_have_is_reported() {
    let folder = place();
    let folder = folder.path();
    // No font has letters for code points that are not assigned.
    let said = draw(folder, "hill.asc --size 200x200 -o a.png", "\u{378} and \u{378} and \u{530}");
    let warnings: Vec<&str> = said.lines().filter(|line| line.contains("title block:")).collect();
    assert!(
        matches!(warnings.as_slice(), [line] if line.ends_with("drawn as question marks: \\u{378} \\u{530}")),
        "{said}"
    );
    for (arguments, words) in [
        ("hill.asc --size 64x100 -o b.png --title x", "--title: a picture of 64x100 px is too small"),
        ("hill.asc --size 32x300 -o b.png --title x", "is too small"),
        ("hill.asc --eyes anaglyph --style pen -o b.svg --title x", "an anaglyph in an .svg has no title block"),
        ("hill.asc --map --style pen -o b.geojson --title x", "a .geojson has no title block"),
    ] {
        let output = program::run(folder, arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(words) && said.trim_end().lines().count() == 1, "{said}");
    }
}
