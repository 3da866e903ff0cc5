//! `bench --sweep`: how exact each setting of a style is, and which sweeps are refused.

use crate::bench::{has_gpu, place_with_quick_flight};
use crate::full;

#[test]
fn a_sweep_measures_how_exact_each_setting_is() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    let line = ["bench", "dem.tif", "--path", "flight.csv", "--size", "160x90", "--frames", "3", "-o", "out", "--json"];
    // In the fast tier the allowed error is swept by `quality` alone.
    let lod_error = if full() { ["--sweep", "lod-error=0.5,16"] } else { ["--lod-error", "0.5"] };
    let sweep = ["--steadiness-pairs", "0", "--sweep", "scale=0.5,1", "--styles", "lsa"];
    let report = place.json(&[&line[..], &lod_error, &sweep].concat());
    let runs = report["runs"].as_array().unwrap();
    let names: Vec<&str> = runs.iter().map(|run| run["style"].as_str().unwrap()).collect();
    let settings: &[&str] = if full() {
        &["lod-error=0.5 scale=0.5", "lod-error=0.5 scale=1", "lod-error=16 scale=0.5", "lod-error=16 scale=1"]
    } else {
        &["scale=0.5", "scale=1"]
    };
    let expected: Vec<String> = settings.iter().map(|setting| format!("lsa {setting}")).collect();
    assert_eq!((names[0], &names[1..]), ("lsa", &expected.iter().map(String::as_str).collect::<Vec<_>>()[..]));
    let scale = serde_json::json!({ "scale": "1" });
    let both = serde_json::json!({ "lod-error": "0.5", "scale": "1" });
    assert_eq!(runs[2]["setting"], if full() { both } else { scale });
    assert!(runs.iter().all(|run| run["exactness"]["views"] == 8.0 && run["is_on_front"].is_boolean()), "{report}");
    let of = |run: usize, name: &str| runs[run]["exactness"][name].as_f64().unwrap();
    // A coarse surface is farther from the heights, and half a picture has half of the lines.
    assert!(!full() || of(4, "surface_error_px") > 4.0 * of(2, "surface_error_px"), "{report}");
    assert!(of(2, "line_recall") > 0.95 && of(2, "line_precision") > 0.95, "{report}");
    assert!(of(1, "tone_error") > 2.0 * of(2, "tone_error"), "{report}");
    // A style without a sweep is measured as before, which `check_schema` tests too.
    if !full() {
        return;
    }
    let alone = place.json(&[&line[..], &["--steadiness-pairs", "0", "--overwrite"]].concat());
    assert!(alone["runs"][0].get("exactness").is_none() && alone["runs"][0].get("setting").is_none());
}

#[test]
fn a_wrong_sweep_is_one_line() {
    let place = place_with_quick_flight();
    for (sweep, cause) in [
        (&["lod-error"][..], "KEY=VALUE,VALUE"),
        (&["lod-error=-1"], "lod-error=-1: it must be"),
        (&["scale=9"], "between 0.25 and 2"),
        (&["antialias=some"], "none or temporal"),
        (&["lines.halvd=true"], "lines.halved"),
        (&["lines.halved=7"], "lines.halved"),
        (&["scale=1", "scale=0.5"], "given twice"),
        (&["lod-error=1,2,3,4,5,6,7,8", "scale=0.5,0.6,0.7,0.8,0.9,1,1.1,1.2,1.3"], "72 settings"),
    ] {
        let options = sweep.iter().flat_map(|sweep| ["--sweep", sweep]);
        let line: Vec<&str> =
            ["bench", "dem.tif", "--path", "flight.csv", "-o", "out"].into_iter().chain(options).collect();
        let text = place.misuse(&line);
        assert!(text.contains(cause) && text.contains("--sweep"), "{sweep:?}: {text}");
        assert!(!place.path("out").exists());
    }
}
