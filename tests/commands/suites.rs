//! `bench --suite`: several benchmarks with one report.

use serde_json::Value;

use crate::Place;
use crate::bench::{has_gpu, place_with_flight};

const SUITE: &str = r#"
title = "Two tables"
about = "A test."

[[tables]]
title = "Lines"
passes = ["lines/lsa"]
columns = ["bytes_per_pixel"]
published = { source = "nobody", quantity = "frame_ms", values = { plain = 4.0, ink = 10.0, "their own" = 3.0 } }
[[tables.parts]]
name = "lines"
bench = ["../dem.tif", "--path", "flight.csv", "--styles", "plain,own.toml", "--size", "640x360", "--frames", "2", "--steadiness-pairs", "0"]

[[tables]]
title = "Sizes"
[[tables.parts]]
name = "small"
bench = ["../dem.tif", "--path", "flight.csv", "--styles", "plain", "--steadiness-pairs", "0"]
[[tables.parts]]
name = "broken"
bench = ["broken.asc", "--path", "flight.csv", "--styles", "plain", "--steadiness-pairs", "0"]
"#;

/// Writes a suite of three parts into the folder `suite`; the last one has a broken DEM.
fn place_with_suite() -> Place {
    let place = place_with_flight();
    std::fs::create_dir(place.path("suite")).unwrap();
    let flight = std::fs::read_to_string(place.path("flight.csv")).unwrap();
    place.file("suite/flight.csv", &flight);
    place.file("suite/own.toml", "name = \"ink\"\nextends = \"lsa\"\n");
    place.file("suite/broken.asc", "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2 3\n4 five 6\n");
    place.file("suite/suite.toml", SUITE);
    place
}

#[test]
fn a_suite_is_measured_as_its_parts_are() {
    if !has_gpu() {
        return;
    }
    let place = place_with_suite();
    let run = place.hachure(&["bench", "--suite", "suite", "--size", "96x54", "--frames", "2", "-o", "out", "--json"]);
    let errors = String::from_utf8(run.stderr).unwrap();
    // The broken part fails, and the others are measured.
    assert_eq!(run.status.code(), Some(1), "{errors}");
    assert!(errors.contains("part 3 of 3: broken") && errors.contains("1 of 3 benchmarks failed: broken"), "{errors}");
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(
        report,
        serde_json::from_str::<Value>(&std::fs::read_to_string(place.path("out/suite.json")).unwrap()).unwrap()
    );
    let [lines, sizes] = [0, 1].map(|number| &report["tables"][number]);
    assert_eq!(sizes["rows"].as_array().unwrap().len(), 1, "{report}");
    assert!(sizes["parts"][1]["error"].as_str().unwrap().contains("broken.asc"), "{report}");
    // What stands in the table is in the report of the part.
    let part: Value =
        serde_json::from_str(&std::fs::read_to_string(place.path("out/lines/report.json")).unwrap()).unwrap();
    assert_eq!(part["size"], serde_json::json!([96, 54]));
    for (row, run) in lines["rows"].as_array().unwrap().iter().zip(part["runs"].as_array().unwrap()) {
        assert_eq!((&row["label"], &row["values"]["frame_ms"]), (&run["style"], &run["frame_ms"]["p50"]));
        let bytes = ["bytes_read", "bytes_written"].map(|key| run["work"][key].as_f64().unwrap());
        let gigabytes = row["values"]["gigabytes"].as_f64().unwrap();
        assert!((gigabytes - (bytes[0] + bytes[1]) / 1e9).abs() < 1e-12, "{row}");
    }
    // A detector reads and writes some bytes for each pixel; a plain picture has none.
    let bytes_px = |row: usize| lines["rows"][row]["values"]["bytes_per_pixel"].as_f64();
    assert!(bytes_px(0).is_none() && bytes_px(1).is_some_and(|bytes| (8.0..80.0).contains(&bytes)), "{lines}");
    let ratio = lines["rows"][1]["ratios"]["gigabytes"].as_f64().unwrap();
    assert!(ratio > 1.02, "{lines}");
    let page = std::fs::read_to_string(place.path("out/suite.html")).unwrap();
    for words in ["2.50", "their own 3 frame ms", "broken failed", "lines/report.html"] {
        assert!(page.contains(words), "{words}: {page}");
    }
    // A second run replaces what the first one wrote, and nothing else.
    let line = ["bench", "--suite", "suite", "--size", "96x54", "--frames", "2", "-o", "out"];
    assert_eq!(place.hachure(&line).status.code(), Some(1));
    place.file("out/suite.html", "my page");
    let error = place.error(&line);
    assert!(error.contains("suite.html"), "{error}");
    assert_eq!(std::fs::read_to_string(place.path("out/suite.html")).unwrap(), "my page");
}

#[test]
fn a_wrong_suite_is_one_line() {
    let place = place_with_suite();
    let line = ["bench", "--suite", "suite", "-o", "out"];
    for (old, new, cause) in [
        ("\"plain,own.toml\"", "\"plain,own.tml\"", "part lines"),
        ("--styles\", \"plain\"", "--stiles\", \"plain\"", "part small: unknown option"),
        ("columns = [\"bytes_per_pixel\"]", "columns = [\"bytes\"]", "bytes_per_pixel"),
        ("title = \"Sizes\"", "titel = \"Sizes\"", "suite.toml:15"),
        ("name = \"small\"", "name = \"lines\"", "two parts are called lines"),
    ] {
        assert!(SUITE.contains(old), "{old}");
        place.file("suite/suite.toml", &SUITE.replace(old, new));
        let output = place.hachure(&line);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && error.lines().count() == 1 && error.contains(cause), "{new}: {error}");
        assert!(!place.path("out/suite.json").exists());
    }
    let error = place.misuse(&["bench", "--suite", "forrest", "-o", "out"]);
    assert!(error.contains("forest") && error.contains("pietrok"), "{error}");
    let error = place.misuse(&["bench", "dem.tif", "--suite", "forest", "-o", "out"]);
    assert!(error.contains("--suite"), "{error}");
    let error = place.misuse(&["bench", "dem.tif", "-o", "out"]);
    assert!(error.contains("--path"), "{error}");
}
