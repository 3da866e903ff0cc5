//! `hachure info` on everything that `render` opens.

use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;

use crate::dem::dem;
use crate::{Place, full};

/// Writes an ASCII grid of 50 × 50 samples whose south-west corner is `west` m east.
fn grid(place: &Place, name: &str, west: i32, of: impl Fn(f64, f64) -> f64) {
    let value = |i: i32| of(f64::from(west / 10 + i % 50), f64::from(i / 50));
    let values: Vec<String> = (0..2500).map(|i| format!("{:.2}", value(i))).collect();
    let header = format!("ncols 50\nnrows 50\nxllcorner {west}\nyllcorner 0\ncellsize 10\n");
    place.file(name, &(header + &values.join(" ")));
}

#[test]
fn folders_are_described_as_one_world() {
    let place = Place::empty();
    std::fs::create_dir(place.path("dems")).unwrap();
    let hills = |x: f64, y: f64| 700.0 + 90.0 * (x / 11.0).sin() * (y / 9.0).cos();
    grid(&place, "dems/b.asc", 0, hills);
    grid(&place, "dems/c.asc", 500, hills);
    grid(&place, "dems/a.asc", 0, |x, y| 45.0 + 44.0 * (x / 11.0).cos() * (y / 2.0).sin() * (x / 1.7).sin());
    image(&place.path("dems/photo.png"));
    place.file("dems/notes.txt", "words");
    let info = place.json(&["info", "dems", "--json"]);
    assert_eq!((&info["kind"], &info["width"], &info["height"]), (&"folder".into(), &100.into(), &50.into()));
    assert_eq!((info["members"].as_array().unwrap().len(), info["left_out"].as_array().unwrap().len()), (2, 2));
    assert!(info["min_m"].as_f64().unwrap() > 600.0, "{info}");
    let text = place.text(&["info", "dems"]);
    assert!(text.contains("a folder of 2 DEMs") && text.contains("left out  dems/a.asc"), "{text}");
    assert!(text.contains("left out  dems/photo.png: is a picture without heights\n"), "{text}");
    // `bake` says the same, and takes the same files.
    let output = place.hachure(&["bake", "dems", "-o", "out.tif", "--json", "--max-error", "0"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("a.asc: left out, because it does not hold its heights").count(), 1, "{said}");
    let baked: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&baked["width"], &baked["min_m"]), (&info["width"], &info["min_m"]));
}

#[test]
fn other_inputs_are_described() {
    let place = Place::empty();
    place.file(
        "quoted.csv",
        "\"t\",\"x\",\"y\",\"z\",\"yaw\",\"pitch\",\"fov\"\n0,0,0,\"+9\",0,0,50\n2,9,0,+9,0,0,50\n",
    );
    assert_eq!(place.json(&["info", "quoted.csv", "--json"])["duration_s"], 2.0);
    let polygons = "{\"type\":\"Polygon\",\"coordinates\":[[[8,47],[9,47],[9,48],[8,47]]]}";
    place.file("bom.geojson", &format!("\u{feff}{polygons}"));
    let info = place.json(&["info", "bom.geojson", "--json"]);
    assert_eq!((&info["kind"], &info["polygons"]), (&"polygons".into(), &1.into()));
    assert_eq!(info["bounds"], serde_json::json!([8.0, 47.0, 9.0, 48.0]));
    place.file("bad.geojson", "{\"type\":\"FeatureCollection\",\"features\":[]}");
    assert_eq!(place.text(&["info", "bad.geojson"]), "bad.geojson: GeoJSON without features, longitude and latitude\n");
    place.file("cut.geojson", "{\"type\":\"Feat");
    let error = place.error(&["info", "cut.geojson"]);
    assert!(error.contains("cut.geojson: it is not GeoJSON: the file ends within a string"), "{error}");
    let line = |kind: &str| {
        format!(
            "{{\"type\":\"Feature\",\"properties\":{{\"kind\":{kind}}},\"geometry\":{{\"type\":\"LineString\",\"coordinates\":[[0,0],[1,1]]}}}}"
        )
    };
    let crs = "\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::32610\"}}";
    let lines = ["\"mark\"", "\"contour line\"", "\"contour line\"", "7"].map(line).join(",");
    place.file("lines.geojson", &format!("{{\"type\":\"FeatureCollection\",{crs},\"features\":[{lines}]}}"));
    let text = "lines.geojson: GeoJSON of 4 lines (2 contour lines, 1 mark), EPSG:32610\n";
    assert_eq!(place.text(&["info", "lines.geojson"]), text);
    assert_eq!(place.json(&["info", "lines.geojson", "--json"])["kinds"]["contour line"], 2);
    place.file("places.csv", "x,y,yaw\n1,2,3\n4,5,6\n");
    assert_eq!(place.json(&["info", "places.csv", "--json"])["positions"], 2);
    place.file("roof.obj", "v 0 0 0\nv 4 0 0\nv 0 3 0\nf 1 2 3\n");
    let model = place.json(&["info", "roof.obj", "--json"]);
    assert_eq!((&model["triangles"], &model["size_m"]), (&1.into(), &serde_json::json!([4.0, 3.0, 0.0])));
}

#[test]
fn pictures_say_how_they_were_drawn() {
    if std::env::var_os("HACHURE_REQUIRE_GPU").is_none() && Gpu::open(&AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return;
    }
    let place = Place::empty();
    dem(&place);
    place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,-900,-900,+150,40,-12,60\n1,-800,-900,+150,40,-12,60\n");
    let camera = "--camera=-900,-900,+150,40,-12,60";
    // The other formats are drawn again by `tests/imprint.rs`.
    let few = ["a.exr", "a.jpg", "a.gif", "a.tif"];
    for (name, more) in [
        ("a.png", &[camera, "--style", "plain"][..]),
        ("a.exr", &[camera, "--style", "plain", "--sun", "100,20"]),
        ("a.svg", &[camera, "--style", "strokes"]),
        ("a.pdf", &[camera, "--style", "strokes"]),
        ("a.jpg", &[camera, "--style", "plain"]),
        ("a.gif", &["--path", "p.csv", "--fps", "2", "--style", "plain"]),
        ("a.tif", &["--map=0,0,900", "--style", "plain", "--samples", "2"]),
    ]
    .into_iter()
    .filter(|(name, _)| full() || few.contains(name))
    {
        place.text(&[&["render", "dem.tif", "-o", name, "--size", "64x36"][..], more].concat());
        let info = place.json(&["info", name, "--json"]);
        assert_eq!((&info["kind"], &info["world"]), (&"picture".into(), &"dem.tif".into()), "{name}");
        assert_eq!(info["size_px"], serde_json::json!([64, 36]), "{name}");
        let text = place.text(&["info", name]);
        assert!(text.contains(&format!("again     hachure render --like {name} -o NEW.")), "{text}");
        // The command draws the same picture.
        let again = format!("again.{}", name.rsplit('.').next().unwrap());
        place.text(&["render", "--like", name, "-o", &again]);
        assert_eq!(std::fs::read(place.path(name)).unwrap(), std::fs::read(place.path(&again)).unwrap(), "{name}");
    }
    let map = place.json(&["info", "a.tif", "--json"]);
    assert_eq!((&map["settings"]["map"], &map["settings"]["samples"]), (&"0,0,900".into(), &2.into()));
    assert_eq!(place.json(&["info", "a.exr", "--json"])["sun_azimuth_deg"], 100.0);
    // A picture of another program is no DEM, and its description is not cut.
    let photo = place.path("photo.png");
    image(&photo);
    let error = place.error(&["info", "photo.png"]);
    assert!(error.contains("holds a colour picture, not heights") && !error.contains('…'), "{error}");
}

fn image(path: &std::path::Path) {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 16);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..16 * 16 * 3_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    hachure::file::atomic::write(path, &bytes).unwrap();
}
