//! SVG files: read by an XML parser, drawn again, and held against the ink of the same frame.

use std::path::Path;
use std::process::Command;

use glam::DVec3;
use hachure::file::svg::{Drawing, Layer, Stroke, Unit, write_svg};
use hachure::frame::{Frame, Light, Requirements};
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::polylines::{EdgeKind, Polyline};
use hachure::style::{Color, Style};
use hachure::surface::view::{Part, View};
use hachure::vector::sheet::Sheet;
use hachure::vector::{DrawingReport, Settings, layers};
use kurbo::{BezPath, ParamCurve, Point, Shape};
use roxmltree::{Document, Node};

use crate::common::World;
use crate::common::hill::Hill;
use crate::polyline;

const SIZE_PX: [u32; 2] = [640, 360];
const NAMESPACE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// What a frame left: its strokes as lines, its ink and whose it is for each pixel.
struct Drawn {
    polylines: Vec<Polyline>,
    ink: Vec<f32>,
    ids: Vec<u32>,
}

fn draw(world: &mut World, camera: &str, change: impl FnOnce(&mut hachure::style::Strokes)) -> Drawn {
    let mut style = Style::load("strokes").unwrap();
    change(style.strokes.as_mut().unwrap());
    let pose = world.pose(camera);
    let view = View { pose, previous: pose, picture_px: SIZE_PX, part: Part::whole(SIZE_PX) };
    let light = Light { to_sun: DVec3::Z, haze_m: 30_000.0, haze_srgb: None };
    let gpu = &world.gpu;
    let mut frame = Frame::new(gpu, Requirements::of(&style), SIZE_PX).unwrap();
    frame.render(gpu, &mut world.terrain, &view, &style, &light);
    let targets = &frame.targets().strokes.as_ref().unwrap().ink;
    let (_, samples) = frame.strokes().unwrap().samples().read(gpu).unwrap();
    let pieces: Vec<u32> = read_as(gpu, &targets.ids, [0, 0], SIZE_PX).unwrap();
    let stroke = |piece: u32| if piece == 0 { 0 } else { samples[piece as usize - 1].stroke };
    let ink: Vec<u16> = read_as(gpu, &targets.ink, [0, 0], SIZE_PX).unwrap();
    Drawn {
        polylines: frame.strokes().unwrap().read_polylines(gpu).unwrap(),
        ink: ink.into_iter().map(|bits| half::f16::from_bits(bits).to_f32()).collect(),
        ids: pieces.into_iter().map(stroke).collect(),
    }
}

fn hill() -> Option<World> {
    World::new(Hill::square(321, 10.0).1, 1.0)
}

const HILL: &str = "0,-1450,+60,0,-2,50";
const RAINIER: &str = "-12000,9000,+900,120,-12,50";

fn settings(sheet: Sheet) -> Settings {
    Settings { tolerance_px: 0.25, sheet, ink: "#14120f".parse::<Color>().unwrap() }
}

/// The text of the file.
fn written(polylines: &[Polyline], settings: &Settings) -> (String, DrawingReport) {
    let (layers, report) = layers(polylines, settings);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.svg");
    write_svg(&path, &drawing(layers, settings)).unwrap();
    assert_eq!(folder.path().read_dir().unwrap().count(), 1, "nothing else is left there");
    (std::fs::read_to_string(&path).unwrap(), report)
}

fn drawing(layers: Vec<Layer>, settings: &Settings) -> Drawing {
    Drawing {
        title: "hills & <\"valleys\">\u{1}".to_owned(),
        description: "one\ntwo".to_owned(),
        size: settings.sheet.size,
        unit: settings.sheet.unit,
        digits: settings.digits(),
        ink: settings.ink.to_string(),
        layers,
    }
}

/// A path of a file.
struct Read {
    layer: String,
    path: BezPath,
    width: f64,
    opacity: f64,
}

/// The paths of a file, in its order; what is not as it should be fails.
fn read(text: &str) -> Vec<Read> {
    assert!(!text.contains("NaN") && !text.contains("inf"));
    let document = Document::parse(text).unwrap();
    let root = document.root_element();
    assert_eq!((root.tag_name().name(), root.tag_name().namespace()), ("svg", Some("http://www.w3.org/2000/svg")));
    let number = |node: &Node<'_, '_>, name: &str| node.attribute(name).map(|text| text.parse::<f64>().unwrap());
    let mut paths = Vec::new();
    for layer in root.children().filter(|node| node.has_tag_name("g")) {
        assert_eq!(layer.attribute((NAMESPACE, "groupmode")), Some("layer"));
        let id = layer.attribute("id").unwrap();
        assert_eq!(layer.attribute((NAMESPACE, "label")).unwrap().to_lowercase(), id);
        assert_eq!((layer.attribute("fill"), layer.attribute("stroke")), (Some("none"), Some("#14120f")));
        assert_eq!(
            (layer.attribute("stroke-linecap"), layer.attribute("stroke-linejoin")),
            (Some("round"), Some("round"))
        );
        for node in layer.children().filter(Node::is_element) {
            assert_eq!(node.tag_name().name(), "path");
            paths.push(Read {
                layer: id.to_owned(),
                path: BezPath::from_svg(node.attribute("d").unwrap()).unwrap(),
                width: number(&node, "stroke-width").unwrap(),
                opacity: number(&node, "stroke-opacity").unwrap_or(1.0),
            });
        }
    }
    assert_eq!(paths.len(), text.matches("<path").count(), "paths stand in layers only");
    paths
}

/// The paths drawn with the pen of the shader: coverage by the distance from the middle, the darker one stays.
fn rasterised(paths: &[Read]) -> Vec<f32> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mut ink = vec![0.0_f32; width * height];
    for read in paths {
        let mut stamp = |at: Point| {
            let reach = 0.5 * read.width + 0.5;
            let range = |middle: f64, most: usize| {
                (middle - reach - 1.0).max(0.0) as usize..((middle + reach + 1.0).max(0.0) as usize).min(most)
            };
            for (x, y) in range(at.y, height).flat_map(|y| range(at.x, width).map(move |x| (x, y))) {
                let distance = at.distance(Point::new(x as f64 + 0.5, y as f64 + 0.5));
                let covered = (reach - distance).clamp(0.0, 1.0) * read.opacity;
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

/// The part of the pixels with `own` ink that have some of the `other` within 1.5 px.
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
    assert!(all > 500, "a picture of something");
    f64::from(found) / f64::from(all)
}

#[test]
fn a_file_shows_what_was_drawn() {
    let real = || World::real("dem/geotiff/mt_rainier_90m.tif", 1.0);
    for (name, world, camera) in [("hill", hill(), HILL), ("Rainier", real(), RAINIER)] {
        let Some(mut world) = world else { continue };
        // Ink that does not fade: SVG mixes it in another way.
        let drawn = draw(&mut world, camera, |strokes| {
            strokes.faintest = 1.0;
            // The hill's strokes taper all along, so that their width is no constant.
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
            "{name}: {} strokes of {} segments; {:.2} % of the ink is there, {:.2} % of what is there was ink, {ratio:.3} \
             times as much; pen up {:.0} px instead of {:.0}",
            report.strokes,
            report.segments,
            100.0 * recall,
            100.0 * precision,
            report.pen_up_px,
            report.pen_up_unordered_px
        );
        assert!(recall >= 0.98 && precision >= 0.98 && (0.95..1.05).contains(&ratio));
        assert!(report.pen_up_px <= report.pen_up_unordered_px);
        // Planted: everything lower; the longest fifth of the strokes gone; too wide.
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

/// The part of the pixels with ink whose stroke passes near by.
fn owned(drawn: &Drawn, number: impl Fn(u32) -> u32) -> f64 {
    let [width, height] = SIZE_PX;
    let (mut all, mut found) = (0_u32, 0_u32);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let id = drawn.ids[(y * width + x) as usize];
        if id == 0 {
            continue;
        }
        all += 1;
        let own = drawn.polylines.iter().find(|line| line.stroke == number(id));
        let near = |line: &Polyline| {
            // Points are 4 px apart at most.
            line.points
                .iter()
                .any(|at| (at.px[0] - x as f32 - 0.5).hypot(at.px[1] - y as f32 - 0.5) < at.half_width_px + 3.0)
        };
        found += u32::from(own.is_some_and(near));
    }
    f64::from(found) / f64::from(all)
}

#[test]
fn strokes_are_read_back_with_their_numbers() {
    let Some(mut world) = hill() else { return };
    let drawn = draw(&mut world, HILL, |_| {});
    assert!(owned(&drawn, |number| number) > 0.999, "{}", owned(&drawn, |number| number));
    assert!(owned(&drawn, |number| number.wrapping_add(1)) < 0.9, "planted: the next one's");
    for line in &drawn.polylines {
        assert!(line.points.len() >= 2);
        assert!(line.points.iter().all(|at| at.half_width_px >= 0.4 && (0.0..=1.0).contains(&at.ink)));
    }
    // Shorter ones are not drawn, and not read.
    let length = |line: &Polyline| {
        let step = |pair: &[hachure::lines::strokes::polylines::PolylinePoint]| {
            (pair[1].px[0] - pair[0].px[0]).hypot(pair[1].px[1] - pair[0].px[1])
        };
        line.points.windows(2).map(step).sum::<f32>()
    };
    let least_px = |drawn: &Drawn| drawn.polylines.iter().map(length).fold(f32::INFINITY, f32::min);
    let long = draw(&mut world, HILL, |strokes| strokes.shortest_px = 40.0);
    assert!(least_px(&drawn) < 30.0 && least_px(&long) > 39.0, "{} {}", least_px(&drawn), least_px(&long));
}

#[test]
fn ink_is_read_back_as_it_is_drawn() {
    let Some(mut world) = hill() else { return };
    let drawn = draw(&mut world, HILL, |strokes| {
        // So wide that a point's pixel is full, and hazy.
        (strokes.width_px, strokes.taper_px, strokes.depth_width, strokes.reach) = (8.0, 0.0, 0.0, 0.06);
    });
    let [width, height] = SIZE_PX;
    let agree = |change: &dyn Fn(f32) -> f32| {
        let (mut all, mut found, mut lightest, mut darkest) = (0_u32, 0_u32, 1.0_f32, 0.0_f32);
        for (line, at) in drawn.polylines.iter().flat_map(|line| line.points.iter().map(move |at| (line, at))) {
            let [x, y] = at.px;
            if x < 0.0 || y < 0.0 || x >= width as f32 || y >= height as f32 {
                continue;
            }
            let pixel = (y as u32 * width + x as u32) as usize;
            if drawn.ids[pixel] == line.stroke {
                all += 1;
                found += u32::from((drawn.ink[pixel] - change(at.ink)).abs() < 0.03);
                (lightest, darkest) = (lightest.min(at.ink), darkest.max(at.ink));
            }
        }
        assert!(all > 100 && darkest - lightest > 0.2, "{all} points from {lightest} to {darkest}");
        f64::from(found) / f64::from(all)
    };
    println!("{:.3} of the points have the picture's ink", agree(&|ink| ink));
    // Where strokes cross the darker one stays, whosever the number is.
    assert!(agree(&|ink| ink) > 0.9);
    assert!(agree(&|ink| ink * 0.9) < 0.5, "planted: too faint");
}

#[test]
fn layers_are_kinds() {
    let Some(mut world) = hill() else { return };
    let mut counts = |change: &dyn Fn(&mut hachure::style::Strokes)| {
        let drawn = draw(&mut world, "0,-1450,+160,0,-6,50", change);
        let (text, report) = written(&drawn.polylines, &settings(Sheet::pixels(SIZE_PX)));
        let paths = read(&text);
        let of = |layer: &str| paths.iter().filter(|read| read.layer == layer).count();
        let ours = ["contours", "borders", "creases"].map(of);
        assert_eq!(ours.map(|count| count as u64), [report.contours, report.borders, report.creases]);
        let kinds = EdgeKind::ALL.map(|kind| drawn.polylines.iter().filter(|line| line.kind == kind).count());
        assert_eq!(ours, kinds);
        let order: Vec<&str> = paths.iter().map(|read| read.layer.as_str()).collect();
        assert!(order.is_sorted_by_key(|layer| ["contours", "borders", "creases"].iter().position(|it| it == layer)));
        ours
    };
    let [contours, borders, creases] = counts(&|_| {});
    assert!(contours > 0 && borders > 0 && creases == 0, "{contours} {borders} {creases}");
    assert_eq!(counts(&|strokes| strokes.borders = false)[1], 0);
    assert!(counts(&|strokes| strokes.crease_deg = Some(3.0))[2] > 0);
}

#[test]
fn paper_has_its_size_and_its_margins() {
    let corners = [Point::new(0.0, 0.0), Point::new(640.0, 0.0), Point::new(640.0, 360.0), Point::new(0.0, 360.0)];
    let frame = [polyline(&corners, EdgeKind::Border, true)];
    for (paper, margin_mm, size_px, expected) in [
        ("a4", 10.0, [640, 360], [297.0, 210.0]),
        ("A4", 10.0, [360, 640], [210.0, 297.0]),
        ("a3", 0.0, [640, 640], [420.0, 297.0]),
        ("300x200.5", 25.0, [640, 360], [300.0, 200.5]),
        ("200.5x300", 25.0, [640, 360], [300.0, 200.5]),
    ] {
        let sheet = Sheet::paper(paper, margin_mm, size_px).unwrap();
        let scale = ((expected[0] - 2.0 * margin_mm) / f64::from(size_px[0]))
            .min((expected[1] - 2.0 * margin_mm) / f64::from(size_px[1]));
        let (text, report) = written(&frame, &settings(sheet));
        let document = Document::parse(&text).unwrap();
        let root = document.root_element();
        let [width, height] = expected;
        assert_eq!(root.attribute("width"), Some(format!("{width}mm").as_str()));
        assert_eq!(root.attribute("height"), Some(format!("{height}mm").as_str()));
        assert_eq!(root.attribute("viewBox"), Some(format!("0 0 {width} {height}").as_str()));
        let paths = read(&text);
        assert!((paths[0].width - 2.0 * scale).abs() < 1e-3);
        assert!((report.pen_down_px - 2000.0).abs() < 1e-6);
        let area = paths[0].path.bounding_box();
        assert!((area.width() - 640.0 * scale).abs() < 0.01 && (area.height() - 360.0 * scale).abs() < 0.01);
        if size_px == SIZE_PX {
            let margins = [area.x0, area.y0, width - area.x1, height - area.y1];
            assert!(margins.iter().all(|margin| *margin > margin_mm - 0.01), "{margins:?}");
            assert!((area.x0 + area.x1 - width).abs() < 0.01 && (area.y0 + area.y1 - height).abs() < 0.01);
            // Planted: a margin of another size.
            let other = Sheet::paper(paper, margin_mm + 1.0, size_px).unwrap();
            assert!((other.units_per_px - sheet.units_per_px).abs() > 1e-3);
        }
    }
    let (text, _) = written(&frame, &settings(Sheet::pixels(SIZE_PX)));
    assert!(text.contains("width=\"640px\" height=\"360px\" viewBox=\"0 0 640 360\""));
    for (paper, margin_mm, cause) in [
        ("a11", 10.0, "--paper \"a11\""),
        ("0x20", 10.0, "--paper"),
        ("NaNx20", 10.0, "--paper"),
        ("20", 10.0, "--paper"),
        ("a4", 105.0, "--margin 105"),
        ("a4", -1.0, "--margin -1"),
        ("a4", f64::NAN, "--margin NaN"),
    ] {
        let error = Sheet::paper(paper, margin_mm, SIZE_PX).unwrap_err();
        assert!(error.starts_with(cause) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn faint_ink_looks_on_white_as_it_does_in_pictures() {
    let mut line = polyline(&[Point::new(10.0, 10.0), Point::new(90.0, 10.0)], EdgeKind::Contour, false);
    let mut look = |ink: f32| {
        line.points.iter_mut().for_each(|point| point.ink = ink);
        let opacity = read(&written(&[line.clone()], &settings(Sheet::pixels(SIZE_PX))).0)[0].opacity;
        // Mixed as written, and mixed as light.
        let dark = 15.0 / 255.0;
        let shown = 1.0 + (dark - 1.0) * opacity;
        let [linear] = [((dark + 0.055_f64) / 1.055).powf(2.4)];
        let drawn = 1.055 * (1.0 + (linear - 1.0) * f64::from(ink)).powf(1.0 / 2.4) - 0.055;
        (opacity, shown, drawn)
    };
    for ink in [0.15, 0.5, 0.9, 1.0] {
        let (_, shown, drawn) = look(ink);
        assert!((shown - drawn).abs() < 2e-3, "{ink}: {shown} {drawn}");
    }
    assert_eq!(look(1.0).0, 1.0);
    // Planted: the part of ink itself would be much darker.
    assert!(look(0.5).0 < 0.4);
}

#[test]
fn nothing_to_draw_is_a_file_without_paths() {
    let Some(mut world) = hill() else { return };
    let drawn = draw(&mut world, "0,0,+500,0,80,20", |_| {});
    let (text, report) = written(&drawn.polylines, &settings(Sheet::pixels(SIZE_PX)));
    assert!(read(&text).is_empty() && report == DrawingReport::default());
    let document = Document::parse(&text).unwrap();
    let of = |name: &str| document.descendants().find(|node| node.has_tag_name(name)).and_then(|node| node.text());
    assert_eq!((of("title"), of("desc")), (Some("hills & <\"valleys\">?"), Some("one two")));
}

#[test]
fn what_is_no_number_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.svg");
    let stroke = Stroke { path: BezPath::from_svg("M1,2 L3,4").unwrap(), width: 1.0, opacity: 0.5 };
    let with = |stroke: Stroke| Layer { id: "contours", label: "Contours", strokes: vec![stroke] };
    let settings = settings(Sheet { size: [1.0; 2], unit: Unit::Px, units_per_px: 1.0, origin: [0.0; 2] });
    let write = |stroke: Stroke, path: &Path| write_svg(path, &drawing(vec![with(stroke)], &settings));
    let mut nowhere = stroke.clone();
    nowhere.path.line_to((f64::NAN, 0.0));
    for bad in
        [nowhere, Stroke { width: f64::INFINITY, ..stroke.clone() }, Stroke { opacity: f64::NAN, ..stroke.clone() }]
    {
        let error = write(bad, &path).unwrap_err().to_string();
        assert!(error.contains("a.svg") && error.contains("not finite"), "{error}");
    }
    let error = write(stroke.clone(), Path::new("no-such-folder/a.svg")).unwrap_err().to_string();
    assert!(error.contains("no-such-folder/a.svg"), "{error}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    write(stroke, &path).unwrap();
}

/// Another program draws it the same.
#[test]
fn librsvg_agrees() {
    let Some(mut world) = hill() else { return };
    if Command::new("rsvg-convert").arg("--version").output().is_err() {
        return println!("skipped: rsvg-convert is not installed");
    }
    let drawn = draw(&mut world, HILL, |strokes| strokes.faintest = 1.0);
    let folder = tempfile::tempdir().unwrap();
    let [svg, png] = ["a.svg", "a.png"].map(|name| folder.path().join(name));
    let settings = settings(Sheet::pixels(SIZE_PX));
    write_svg(&svg, &drawing(layers(&drawn.polylines, &settings).0, &settings)).unwrap();
    let done = Command::new("rsvg-convert").arg(&svg).arg("-o").arg(&png).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let picture = hachure::file::png::read_rgba8(&png).unwrap();
    assert_eq!([picture.width, picture.height], SIZE_PX);
    // Without a background: the alpha is the ink.
    let ink: Vec<f32> = picture.rgba.chunks_exact(4).map(|texel| f32::from(texel[3]) / 255.0).collect();
    let (recall, precision) = (covered(&drawn.ink, &ink), covered(&ink, &drawn.ink));
    println!(
        "librsvg: {:.2} % of the ink is there, {:.2} % of what is there was ink",
        100.0 * recall,
        100.0 * precision
    );
    assert!(recall >= 0.98 && precision >= 0.98);
}
