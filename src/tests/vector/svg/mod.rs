//! Tests SVG files: they are read by an XML parser, rasterised, and compared with the ink of the same frame.

pub mod again;
mod file;
mod strokes;

pub use self::again::rasterised_at;
use hachure::file::svg::{Drawing, Layer, write_svg};
use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::polylines::Polyline;
use hachure::lines::strokes::stroke::{INK, STROKE_IDS};
use hachure::style::Color;
use hachure::vector::sheet::Sheet;
use hachure::vector::{DrawingReport, Settings, groups, layers};
use kurbo::BezPath;
use roxmltree::{Document, Node};

use crate::tests::common::World;
use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::hill::Hill;

const SIZE_PX: [u32; 2] = [640, 360];
const NAMESPACE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// Results of a frame: its strokes as lines, and the ink and the stroke of each pixel.
struct Drawn {
    polylines: Vec<Polyline>,
    ink: Vec<f32>,
    ids: Vec<u32>,
}

fn strokes_of(world: &mut World, camera: &str, change: impl FnOnce(&mut hachure::style::Strokes)) -> Drawn {
    let mut style = crate::tests::common::all_lines("strokes");
    change(style.strokes_mut().unwrap());
    let view = still(world.pose(camera), SIZE_PX);
    let gpu = &world.gpu;
    let mut renderer = Renderer::new(gpu).unwrap();
    draw(gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
    let (_, samples) = renderer.strokes().unwrap().samples().read(gpu).unwrap();
    let segments: Vec<u32> = read_as(gpu, renderer.target(&STROKE_IDS).unwrap(), [0, 0], SIZE_PX).unwrap();
    let stroke = |segment: u32| if segment == 0 { 0 } else { samples[segment as usize - 1].stroke };
    let ink: Vec<u16> = read_as(gpu, renderer.target(&INK).unwrap(), [0, 0], SIZE_PX).unwrap();
    Drawn {
        polylines: renderer.strokes().unwrap().read_polylines(gpu).unwrap(),
        ink: ink.into_iter().map(|bits| half::f16::from_bits(bits).to_f32()).collect(),
        ids: segments.into_iter().map(stroke).collect(),
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

/// Returns the text of the file, and the report.
fn written(polylines: &[Polyline], settings: &Settings) -> (String, DrawingReport) {
    let (layers, report) = layers(&groups(polylines, settings.ink), settings, None);
    (written_layers(layers, settings), report)
}

/// Returns the text of a file with these layers.
pub fn written_layers(layers: Vec<Layer>, settings: &Settings) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.svg");
    write_svg(&path, &drawing(layers, settings), None).unwrap();
    assert_eq!(folder.path().read_dir().unwrap().count(), 1, "no other file may remain");
    std::fs::read_to_string(&path).unwrap()
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

/// A path in a file.
pub struct Read {
    pub layer: String,
    pub color: String,
    path: BezPath,
    pub width: f64,
    pub opacity: f64,
}

/// Returns the paths of a file, in its order, and checks its structure.
pub fn read(text: &str) -> Vec<Read> {
    assert!(!text.contains("NaN") && !text.contains("inf"));
    let document = Document::parse(text).unwrap();
    let root = document.root_element();
    assert_eq!((root.tag_name().name(), root.tag_name().namespace()), ("svg", Some("http://www.w3.org/2000/svg")));
    let number = |node: &Node<'_, '_>, name: &str| node.attribute(name).map(|text| text.parse::<f64>().unwrap());
    let mut paths = Vec::new();
    for layer in root.children().filter(|node| node.has_tag_name("g")) {
        assert_eq!(layer.attribute((NAMESPACE, "groupmode")), Some("layer"));
        let id = layer.attribute("id").unwrap();
        let label = layer.attribute((NAMESPACE, "label")).unwrap().to_lowercase();
        let label = label.split_once(". pen: ").map_or(label.as_str(), |(_, label)| label);
        // Ids are stable names for scripts, labels are for people.
        let first_word = match id.split('-').collect::<Vec<_>>().as_slice() {
            ["marks", ..] => "hatching",
            ["heights", ..] => "contour",
            ["cuts", ..] => "cut",
            ["rims", ..] => "outlines",
            ["hachures", ..] => "hachures",
            ["water", ..] => "shores",
            ["tone", "highlights"] => "highlight",
            ["tone", ..] => "dark",
            [first, ..] => first,
            [] => "",
        };
        assert_eq!(label.split([' ', ',']).next(), Some(first_word));
        assert!(layer.attribute("fill") == Some("none") && layer.attribute("stroke").unwrap().starts_with('#'));
        assert_eq!(
            (layer.attribute("stroke-linecap"), layer.attribute("stroke-linejoin")),
            (Some("round"), Some("round"))
        );
        for node in layer.children().filter(Node::is_element) {
            assert_eq!(node.tag_name().name(), "path");
            paths.push(Read {
                layer: id.to_owned(),
                color: layer.attribute("stroke").unwrap().to_owned(),
                path: BezPath::from_svg(node.attribute("d").unwrap()).unwrap(),
                width: number(&node, "stroke-width").unwrap(),
                opacity: number(&node, "stroke-opacity").unwrap_or(1.0),
            });
        }
    }
    assert_eq!(paths.len(), text.matches("<path").count(), "all paths must be in layers");
    paths
}
