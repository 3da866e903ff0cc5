//! The same features in every format are read as the same features.

use super::super::{Attributes, CrsOrigin, Feature, Geometry, Value};
use super::{Folder, differences, read_all, read_text, samples, writers};

#[test]
fn every_format_gives_the_same_features() {
    let folder = Folder::new();
    for has_z in [false, true] {
        let expected = samples(has_z);
        let database = folder.path(if has_z { "z.gpkg" } else { "a.gpkg" });
        writers::geopackage(&database, &expected);
        let lines: Vec<String> = expected.iter().map(writers::json_feature).collect();
        let paths = [
            folder.write("a.geojson", writers::geojson(&expected)),
            folder.write("a.geojsonl", lines.join("\n")),
            folder.write("a.sequence", format!("\u{1e}{}\n", lines.join("\n\u{1e}"))),
            folder.write("bom.geojson", format!("\u{feff}{}", writers::geojson(&expected))),
            folder.write("comma.csv", writers::csv(&expected, ',')),
            folder.write("semicolon.csv", format!("\u{feff}{}", writers::csv(&expected, ';'))),
            folder.write("tab.tsv", writers::csv(&expected, '\t')),
            folder.write("a.fgb", writers::flatgeobuf(&expected, has_z, false)),
            database,
        ];
        for path in paths {
            let (found, summary) = read_all(&path, None).unwrap();
            assert_eq!(differences(&expected, &found), Vec::<String>::new(), "{}", path.display());
            assert_eq!((summary.layers[0].features, summary.is_complete), (6, true));
            assert_eq!(summary.skipped, [], "{}", path.display());
            let bounds = summary.bounds.unwrap();
            assert_eq!((bounds.min, bounds.max), ([-3.5, 0.0], [29.0, 45.976_6]));
            let kinds = |name: &str| {
                let found = summary.attributes.iter().find(|it| &*it.name == name).unwrap();
                [found.texts, found.numbers, found.bools]
            };
            assert_eq!(
                [kinds("name"), kinds("ele"), kinds("climbed"), kinds("class")],
                [[4, 0, 0], [0, 3, 0], [0, 0, 3], [2, 0, 0]]
            );
            let records: Vec<u64> = found.iter().map(|feature| feature.record).collect();
            let first = if summary.format == "CSV" { 2 } else { 1 };
            assert_eq!(records, (first..first + 6).collect::<Vec<_>>(), "{}", path.display());
        }
    }
}

#[test]
fn an_index_changes_the_order_only() {
    let folder = Folder::new();
    let expected = samples(true);
    let (mut found, summary) =
        read_all(&folder.write("a.fgb", writers::flatgeobuf(&expected, true, true)), None).unwrap();
    let place = |feature: &Feature| {
        expected.iter().position(|own| differences(std::slice::from_ref(own), std::slice::from_ref(feature)).is_empty())
    };
    found.sort_by_key(place);
    assert_eq!(differences(&expected, &found), Vec::<String>::new());
    let crs = summary.crs.unwrap();
    assert_eq!((crs.text.as_str(), crs.origin), ("EPSG:4326", CrsOrigin::File));
}

#[test]
fn gpx_gives_the_same_points_and_lines() {
    let mut expected = Vec::new();
    let mut lines = Vec::new();
    for feature in samples(true) {
        let mut attributes = feature.attributes.clone();
        ["ele", "climbed", "class"].into_iter().for_each(|name| attributes.remove(name));
        match feature.geometry {
            Geometry::Points(points) => expected.extend(points.into_iter().map(|point| {
                let mut attributes: Attributes = attributes.clone();
                attributes.push("ele".into(), Value::Number(point[2]));
                Feature { geometry: Geometry::Points(vec![point]), attributes, ..feature }
            })),
            Geometry::Lines(_) => lines.push(Feature { attributes, ..feature }),
            Geometry::Areas(_) => {}
        }
    }
    expected.extend(lines);
    let (found, summary) = read_text("a.gpx", writers::gpx(&samples(true))).unwrap();
    assert_eq!(differences(&expected, &found), Vec::<String>::new());
    let counts: Vec<(&str, u64)> = summary.layers.iter().map(|it| (it.name.as_str(), it.features)).collect();
    assert_eq!(counts, [("waypoints", 3), ("routes", 0), ("tracks", 2)]);
    assert_eq!(summary.crs.unwrap().origin, CrsOrigin::Format);
}

/// A comparison that finds nothing would make the other tests pass.
#[test]
fn planted_errors_are_found() {
    let expected = samples(true);
    for planted in 0..expected.len() {
        let mut exchanged = samples(true);
        let position = match &mut exchanged[planted].geometry {
            Geometry::Points(points) => points.last_mut(),
            Geometry::Lines(lines) => lines.last_mut().and_then(|line| line.last_mut()),
            Geometry::Areas(areas) => {
                areas.last_mut().and_then(|area| area.holes.last_mut().unwrap_or(&mut area.outer).last_mut())
            }
        };
        position.unwrap().swap(0, 1);
        let mut lost = samples(true);
        let name = lost[planted].attributes.iter().next().unwrap().0.to_string();
        lost[planted].attributes.remove(&name);
        for changed in [exchanged, lost] {
            for (name, bytes) in [
                ("a.geojson", writers::geojson(&changed).into_bytes()),
                ("a.csv", writers::csv(&changed, ';').into_bytes()),
                ("a.fgb", writers::flatgeobuf(&changed, true, false)),
            ] {
                let (found, _) = read_text(name, bytes).unwrap();
                let differences = differences(&expected, &found);
                assert!(
                    matches!(differences.as_slice(), [one] if one.starts_with(&format!("feature {planted}: "))),
                    "{name}: {differences:?}"
                );
            }
        }
    }
}
