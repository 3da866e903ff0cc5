//! Files as programs and people write them, and what is said about those that cannot be read.

use std::ops::ControlFlow;

use super::super::{Choice, CrsOrigin, Geometry, Reason, Skipped, Value, read, survey};
use super::{Folder, error_of, read_all, read_text};

fn first_point(name: &str, text: &str) -> [f64; 2] {
    let (features, _) = read_text(name, text).unwrap();
    let [x, y, _] = *features[0].geometry.positions().next().unwrap();
    [x, y]
}

#[test]
fn geojson_in_any_order_and_form() {
    let point = "{\"type\":\"Point\",\"coordinates\":[8,47]}";
    for text in [
        point.to_owned(),
        "{\"coordinates\":[8,47,null],\"type\":\"Point\"}".to_owned(),
        format!("{{\"geometry\":{point},\"type\":\"Feature\"}}"),
        format!(
            "{{\"features\":[{{\"geometry\":{point},\"properties\":null,\"type\":\"Feature\"}}],\"type\":\"FeatureCollection\"}}"
        ),
        format!(
            "{{\"type\":\"GeometryCollection\",\"geometries\":[{{\"type\":\"GeometryCollection\",\"geometries\":[{point}]}}]}}"
        ),
        format!("  \n{{\"x\":{{\"features\":[1]}},\"type\":\"FeatureCollection\",\"features\":[{point}]}}"),
    ] {
        assert_eq!(first_point("a.txt", &text), [8.0, 47.0], "{text}");
    }
    let (features, summary) = read_text(
        "a.json",
        "{\"features\":[{\"id\":\"way/1\",\"type\":\"Feature\",\"properties\":{\"list\":[1,{\"a\":[]}],\"hash\":18446744073709551615},\
         \"geometry\":{\"type\":\"GeometryCollection\",\"geometries\":[{\"type\":\"Point\",\"coordinates\":[1,2]},\
         {\"type\":\"LineString\",\"coordinates\":[[1,2],[3,4]]}]}}],\"name\":\"roads\",\"crs\":{\"type\":\"name\",\
         \"properties\":{\"name\":\"urn:ogc:def:crs:EPSG::32632\"}},\"type\":\"FeatureCollection\"}",
    )
    .unwrap();
    assert!(matches!((&features[0].geometry, &features[1].geometry), (Geometry::Points(_), Geometry::Lines(_))));
    for feature in &features {
        assert_eq!(feature.attributes.get("list"), &Value::Text("[1,{\"a\":[]}]".into()));
        assert_eq!(feature.attributes.get("hash"), &Value::Text("18446744073709551615".into()));
        assert_eq!((feature.attributes.get("id"), feature.record), (&Value::Text("way/1".into()), 1));
    }
    let crs = summary.crs.unwrap();
    assert_eq!(
        (crs.text.as_str(), crs.origin, summary.layers[0].name.as_str()),
        ("EPSG:32632", CrsOrigin::File, "roads")
    );
}

#[test]
fn parts_of_geojson_are_left_out_and_counted() {
    let line = |text: &str| format!("{{\"type\":\"Feature\",\"geometry\":{text}}}\n");
    let text = [
        line("null"),
        line("{\"type\":\"Polygon\",\"coordinates\":[]}"),
        line("{\"type\":\"LineString\",\"coordinates\":[[1,2]]}"),
        line("{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1,1],[0,0]]]}"),
        line("{\"type\":\"Point\",\"coordinates\":[1]}"),
        line("{\"type\":\"Point\",\"coordinates\":[1,\"2\"]}"),
        line("{\"type\":\"Point\",\"coordinates\":[[1,2]]}"),
        line("{\"type\":\"MultiPolygon\",\"coordinates\":[[[[0,0],[4,0],[4,4]],[[1,1],[2,2]],[]],[[[0,0]]]]}"),
    ]
    .concat();
    let (features, summary) = read_text("a.geojsonl", text).unwrap();
    assert_eq!((features.len(), features[0].record), (1, 8));
    let skipped = |reason, features, parts, first| Skipped { reason, features, parts, first };
    let lists = Reason::Damaged("its lists are not nested as its type requires");
    assert_eq!(
        summary.skipped,
        [
            skipped(Reason::NoGeometry, 1, 0, 1),
            skipped(Reason::Empty, 1, 1, 2),
            skipped(Reason::ShortLine, 1, 0, 3),
            skipped(Reason::ShortRing, 1, 2, 4),
            skipped(Reason::NotFinite, 2, 0, 5),
            skipped(lists, 1, 0, 7),
        ]
    );
}

#[test]
fn errors_of_geojson() {
    let deep = format!("{{\"type\":\"Point\",\"coordinates\":{}", "[".repeat(100_000));
    let nested = format!(
        "{}{{\"type\":\"Point\",\"coordinates\":[1,2]}}{}",
        "{\"type\":\"GeometryCollection\",\"geometries\":[".repeat(12),
        "]}".repeat(12)
    );
    for (text, expected) in [
        ("", "is empty"),
        (" \n", "is empty"),
        ("[1]", "is a JSON list, not a GeoJSON object"),
        ("{}", "is not valid GeoJSON: an object has no type"),
        ("{\"type\":\"Topology\"}", "is not valid GeoJSON: an object has the unknown type \"Topology\""),
        ("{\"type\":\"FeatureCollection\"}", "is not valid GeoJSON: its collection has no features"),
        ("{\"features\":[]}", "is not valid GeoJSON: an object has features, but not the type FeatureCollection"),
        ("{\"type\":\"Point\",\"coordinates\":[1,NaN]}", "is not valid GeoJSON: expected value (line 1, column 34)"),
        ("{\"type\":\"Point\",\n\"coordinates\":[1,2", "ends within a list (line 2, column 18); it is truncated"),
        ("{\"type\":\"P\u{fffd}\"}", "is not valid GeoJSON: an object has the unknown type"),
        (&deep, "is not valid GeoJSON: recursion limit exceeded"),
        (&nested, "is not valid GeoJSON: its collections are nested more than 8 deep"),
        (
            "{\"type\":\"FeatureCollection\",\"features\":[],\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"Mars\"}}}",
            "has the unknown crs \"Mars\"; convert it with ogr2ogr -t_srs EPSG:4326",
        ),
    ] {
        let error = error_of("a.geojson", text);
        assert!(error.starts_with(&format!("a.geojson: {expected}")), "{error}");
    }
    let error = error_of("a.geojson", b"{\"type\":\"Feature\",\"properties\":{\"a\":\"h\xf6he\"},\"geometry\":null}");
    assert_eq!(error, "a.geojson: is not UTF-8 text (line 1, column 39); convert it with iconv -t UTF-8");
}

#[test]
fn csv_as_spreadsheets_write_it() {
    for text in [
        "name,lat,lon\nA,47,8\n",
        "Longitude;Latitude;name\r\n8,0;47,0;A\r\n;;\r\n",
        "X\tY\tname\n8\t47\tA\n",
        "name,geom\nA,\"SRID=4326;POINT(8 47)\"\n",
        "Easting,Northing,\n8,47,\n",
        "x,y\n\"8\",\"47\"",
        "name;x;y;ele\nA;8,0;47,0;1.234,5\n",
        "name,x,y\rA,8,47\rB,9,48",
        "name,x,y\n\"A\nB\",8,\"47\"\r\n",
    ] {
        assert_eq!(first_point("a.csv", text), [8.0, 47.0], "{text}");
    }
    let (features, summary) = read_text("a.csv", "lon;lat;ele;n\n8,5;47;12,25;1,5\n").unwrap();
    let position = *features[0].geometry.positions().next().unwrap();
    assert_eq!(position, [8.5, 47.0, 12.25]);
    assert_eq!(
        [features[0].attributes.get("ele"), features[0].attributes.get("n")],
        [&Value::Number(12.25), &Value::Number(1.5)]
    );
    assert_eq!(summary.crs.map(|crs| crs.origin), Some(CrsOrigin::Assumed));
    let (features, summary) = read_text("a.csv", "x,y,n\n1,2,3\n1,b,3\n1,2\r\n1,2,3,4\n\n5,6,7,\n1,inf,3\n").unwrap();
    assert_eq!(features.iter().map(|it| it.record).collect::<Vec<_>>(), [2, 7]);
    let skipped = |reason, features, first| Skipped { reason, features, parts: 0, first };
    assert_eq!(summary.skipped, [skipped(Reason::NotFinite, 2, 3), skipped(Reason::Fields, 2, 4)]);
    assert_eq!(summary.crs, None);
}

#[test]
fn errors_of_csv() {
    for (text, expected) in [
        (&b"a;b\n1;2\n"[..], "has no columns of coordinates; its columns are a, b; tried lon/lat, long/lat,"),
        (b"name,x,y\nZ\xfcrich,1,2\n", "is not UTF-8 text (line 2); convert it with iconv -f LATIN1 -t UTF-8"),
        (b"\xff\xfex\0,\0y\0", "is UTF-16 text; save it as UTF-8"),
        (b"wkt\nSRID=1;POINT(1 2)\nSRID=2;POINT(1 2)\n", "contains several reference systems (SRID=); it needs one"),
        (b"x,y\0\0\x01", "has an unknown format; hachure reads features from GeoJSON, GPX, CSV"),
    ] {
        let error = error_of("a.csv", text);
        assert!(error.starts_with(&format!("a.csv: {expected}")), "{error}");
    }
}

#[test]
fn gpx_as_devices_write_it() {
    let text = "<?xml version='1.0' encoding='utf-8'?>\n<!-- <kml> -->\n<g:gpx xmlns:g='http://www.topografix.com/GPX/1/0' version='1.0'>\
        <metadata><name>file</name><wpt lat='1' lon='1'/></metadata>\
        <g:rte><g:name>R &amp; <![CDATA[<b>]]> &#228;</g:name><rtept lat='1' lon='2'><name>x</name></rtept><rtept lat='3' lon='4'/></g:rte>\
        <trk><name>T</name><number>3</number><extensions><trk><trkseg><name>no</name></trkseg></trk></extensions>\
        <trkseg><trkpt lat='1' lon='2'><ele>5.5</ele><time>t</time></trkpt><trkpt lat='1' lon='3'/></trkseg>\
        <trkseg><trkpt lat='1' lon='2'/></trkseg></trk>\
        <trk><name>empty</name></trk>\
        <wpt lat='46.5' lon='7.25'><time>2026-05-01T08:00:00Z</time><ele>1500</ele><type>hut</type><desc> </desc></wpt>\
        <wpt lat='95' lon='7'/><wpt lon='7'/></g:gpx>";
    let (features, summary) = read_text("a.gpx", text).unwrap();
    assert_eq!(features.iter().map(|it| (it.layer, it.record)).collect::<Vec<_>>(), [(1, 1), (2, 2), (0, 4)]);
    assert_eq!(features[0].attributes.get("name"), &Value::Text("R & <b> ä".into()));
    assert_eq!(
        (features[1].attributes.get("name"), features[1].attributes.get("number")),
        (&Value::Text("T".into()), &Value::Number(3.0))
    );
    assert!(
        matches!(&features[1].geometry, Geometry::Lines(lines) if lines.len() == 1 && lines[0][0] == [2.0, 1.0, 5.5])
    );
    assert_eq!(features[2].attributes.get("type"), &Value::Text("hut".into()));
    assert_eq!(features[2].geometry.positions().next(), Some(&[7.25, 46.5, 1500.0]));
    let skipped = |reason, features, parts, first| Skipped { reason, features, parts, first };
    assert_eq!(
        summary.skipped,
        [skipped(Reason::ShortLine, 0, 1, 2), skipped(Reason::Empty, 1, 0, 3), skipped(Reason::NotFinite, 2, 0, 5)]
    );
    let folder = Folder::new();
    let path = folder.write("a.gpx", text);
    assert_eq!(read_all(&path, Some("tracks")).unwrap().0.len(), 1);
    let error = read_all(&path, Some("huts")).unwrap_err().to_string();
    assert!(error.ends_with("has no layer \"huts\"; its layers are waypoints, routes, tracks"), "{error}");
}

#[test]
fn errors_of_gpx() {
    let deep = format!("<gpx>{}", "<a>".repeat(1000));
    for (text, expected) in [
        ("<gpx><wpt lat='1' lon='1'>", "ends before its last element does; it is truncated (byte 26)"),
        ("<gpx><wpt></gpx>", "is not valid GPX: ill-formed document: expected `</wpt>`, but `</gpx>` was found (byte"),
        ("<gpx", "is not valid GPX: syntax error"),
        (&deep, "has elements that are nested more than 64 deep (byte"),
        ("<?xml version='1.0' encoding='ISO-8859-1'?><gpx/>", "is ISO-8859-1 text; convert it to UTF-8"),
        ("<kml/>", "is a KML file; convert it with ogr2ogr OUT.gpkg IN.kml"),
        ("<x/>", "is XML, but not GPX; hachure reads features"),
        ("plain", "is not GPX, which begins with <"),
        ("<gpx/><gpx/>x<y/>", "is XML, but has an element outside of gpx (byte"),
    ] {
        let error = error_of("a.gpx", text);
        assert!(error.starts_with(&format!("a.gpx: {expected}")), "{error}");
    }
}

#[test]
fn hostile_headers_of_flatgeobuf() {
    let features = super::samples(false);
    let whole = super::writers::flatgeobuf(&features, false, true);
    let with = |place: usize, bytes: &[u8]| {
        let mut changed = whole.clone();
        changed[place..place + bytes.len()].copy_from_slice(bytes);
        error_of("a.fgb", changed)
    };
    let huge = u32::MAX.to_le_bytes();
    assert!(with(8, &huge).contains("its header is damaged: it is said to have 4294967295 bytes"));
    assert_eq!(with(3, &[2]), "a.fgb: is FlatGeobuf of version 2; only version 3 can be read");
    // The number of features is the only u64 of its value in the header.
    let count = (6_u64).to_le_bytes();
    let place = whole.windows(8).position(|window| window == count).unwrap();
    for hostile in [u64::MAX, 1 << 40] {
        let error = with(place, &hostile.to_le_bytes());
        assert!(error.contains("its index is larger than the file"), "{error}");
    }
    let mut changed = super::writers::flatgeobuf(&features, false, false);
    let place = changed.windows(8).position(|window| window == count).unwrap();
    changed[place] = 7;
    assert_eq!(error_of("a.fgb", changed), "a.fgb: is truncated: it has 6 of 7 features");
}

#[test]
fn a_caller_may_end_early_and_files_have_one_layer() {
    let folder = Folder::new();
    let features = super::samples(false);
    let database = folder.path("a.gpkg");
    super::writers::geopackage(&database, &features);
    for path in [
        folder.write("a.geojson", super::writers::geojson(&features)),
        folder.write("a.csv", super::writers::csv(&features, ',')),
        folder.write("a.fgb", super::writers::flatgeobuf(&features, false, false)),
        folder.write("a.gpx", super::writers::gpx(&features)),
        database,
    ] {
        let mut count = 0;
        let summary = read(&path, &Choice::default(), &mut |_| {
            count += 1;
            if count == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
        assert_eq!((count, summary.is_complete), (2, false), "{}", path.display());
        assert!(survey(&path, &Choice::default()).unwrap().is_complete);
        let error = survey(&path, &Choice { layer: Some("b".into()) }).unwrap_err().to_string();
        assert!(error.contains("has no layer \"b\"; its "), "{error}");
    }
}

#[test]
fn what_is_no_layer_is_named() {
    let folder = Folder::new();
    for (bytes, expected) in [
        (&b"PK\x03\x04"[..], "is a ZIP archive; unpack it; hachure reads features from"),
        (b"\0\0\x27\x0a", "is a shapefile; convert it with ogr2ogr OUT.gpkg IN.shp"),
        (b"<html>", "is a web page; perhaps a download failed"),
    ] {
        let error = error_of("a.bin", bytes);
        assert!(error.starts_with(&format!("a.bin: {expected}")), "{error}");
    }
    let error = read_all(&folder.path("none.gpkg"), None).unwrap_err().to_string();
    assert!(error.ends_with("none.gpkg: cannot be read: there is no such file"), "{error}");
    let error = read_all(&folder.path("."), None).unwrap_err().to_string();
    assert!(error.ends_with(": cannot be read: it is a folder, not a file"), "{error}");
}
