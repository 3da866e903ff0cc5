//! `--quality`: pictures and benchmarks with a point of a measured front.

use crate::bench::{has_gpu, place_with_quick_flight};
use crate::full;

#[test]
fn a_front_is_measured_and_drawn_with() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    // One key is enough for a cheap point and an exact one, and without strokes a view has fewer frames.
    let (style, size) = if full() { ("ink", "160x90") } else { ("lsa", "96x54") };
    let of_strokes: &[&str] = if full() { &["--sweep", "strokes.resolution=0.5,1"] } else { &[] };
    let flight = ["bench", "dem.tif", "--path", "flight.csv", "--frames", "2", "--steadiness-pairs", "0"];
    let bench = [&flight[..], &["--styles", style, "--size", size]].concat();
    place.text(&[&bench[..], &["--sweep", "lod-error=0.5,64", "-o", "trade"], of_strokes].concat());
    let name = format!("front-{style}.toml");
    let path = format!("trade/{name}");
    let text = std::fs::read_to_string(place.path(&path)).unwrap();
    let front: toml::Table = text.parse().unwrap();
    let points = front["points"].as_array().unwrap();
    let of = |level: &str| {
        let has =
            |point: &&toml::Value| point["levels"].as_array().unwrap().iter().any(|it| it.as_str() == Some(level));
        points.iter().filter(|point| point.get("levels").is_some()).find(has).unwrap()
    };
    let value = |level: &str, key: &str| of(level)["set"].get(key).and_then(|text| text.as_str()).map(str::to_owned);
    assert_eq!(value("draft", "lod-error").as_deref(), Some("64"), "{text}");
    assert_ne!(value("exact", "lod-error").as_deref(), Some("64"), "{text}");
    let surface_error_px = |level: &str| of(level)["errors"]["surface_error_px"].as_float().unwrap();
    assert!(surface_error_px("draft") > 4.0 * surface_error_px("exact"), "{text}");

    // A picture of a quality is that of its values, and what is given wins.
    let camera = ["render", "dem.tif", "--camera=-900,-900,+150,40,-12,60", "--size", size];
    let own = [&camera[..], &["--style", style]].concat();
    let resolution = value("draft", "strokes.resolution").map(|value| format!("strokes.resolution={value}"));
    assert_eq!(resolution.is_some(), full(), "{text}");
    let set: Vec<&str> = resolution.iter().flat_map(|text| ["--set", text.as_str()]).collect();
    place.text(&[&own[..], &["--lod-error", "64", "-o", "by_hand.png"], &set[..]].concat());
    let draft = ["--quality", "draft", "--front", &path];
    place.text(&[&own[..], &draft, &["-o", "draft.png"]].concat());
    place.text(&[&own[..], &draft, &["--lod-error", "0.5", "-o", "fine.png"]].concat());
    let pixels = |name: &str| {
        let text = std::fs::File::open(place.path(name)).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(text)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    assert_eq!(pixels("draft.png"), pixels("by_hand.png"));
    assert_ne!(pixels("draft.png"), pixels("fine.png"));
    // The picture is drawn again without the front.
    place.text(&["render", "--like", "draft.png", "-o", "again.png"]);
    assert_eq!(pixels("again.png"), pixels("draft.png"));

    // A benchmark flies with it.
    let report = place.json(&[&bench[..], &draft, &["-o", "fast", "--json"]].concat());
    assert_eq!(report["settings"]["quality"], "draft");
    assert_eq!(report["runs"][0]["allowed_error_px"]["p50"], 64.0, "{report}");

    for (arguments, cause) in [
        (
            &["--quality", "draft", "--style", "plain"][..],
            "plain has no measured settings for --quality and --budget (presets that have some: crosshatch, ink, ",
        ),
        (&["--quality", "best"], "draft"),
        (&["--front", path.as_str()], "--quality"),
        (&["--quality", "draft", "--like", "draft.png"], "--like"),
    ] {
        let error = place.misuse(&[&["render", "-o", "no.png"], arguments].concat());
        assert!(error.contains(cause), "{arguments:?}: {error}");
    }
    let error = place.error(&[&camera[..], &draft, &["--style", "plain", "-o", "no.png"]].concat());
    assert!(error.contains(&name) && error.contains("plain"), "{error}");
    // A front of somebody else is not overwritten.
    std::fs::create_dir(place.path("other")).unwrap();
    place.file(&format!("other/{name}"), "mine = 1");
    let error = place.error(&[&bench[..], &["--sweep", "lod-error=1,2", "-o", "other"]].concat());
    assert!(error.contains(&name), "{error}");
}

#[test]
fn a_governor_holds_a_budget_in_a_flight() {
    if !has_gpu() {
        return;
    }
    let place = place_with_quick_flight();
    let (style, size) = if full() { ("ink", "160x90") } else { ("lsa", "96x54") };
    let path =
        |end_s: u32| format!("t,x,y,z,yaw,pitch,fov\n0,-900,-900,+150,40,-12,60\n{end_s},300,200,+120,60,-10,60\n");
    place.file("long.csv", &path(4));
    // The governor is judged from the second second on.
    place.file("short.csv", &path(if full() { 4 } else { 2 }));
    let point = |levels: &str, cost: f64, error_px: &str| {
        format!(
            "[[points]]\nlevels = [{levels}]\ncost = {cost:?}\ncost_ratio = {cost:?}\nset = {{ lod-error = \"{error_px}\" }}\n\
             errors = {{ lines_lost_percent = 1.0 }}\n"
        )
    };
    let front = format!("style = \"{style}\"\nadapter = \"\"\nsize = [160, 90]\ncost = \"GB moved\"\n")
        + &point("\"draft\"", 1.0, "32")
        + &point("\"balanced\"", 1.2, "4")
        + &point("\"exact\"", 1.5, "0.5");
    place.file("front.toml", &front);
    let fly = |budget: &str, name: &str| {
        let path = format!("{name}.csv");
        let bench = ["bench", "dem.tif", "--path", &path, "--styles", style, "--size", size, "--real-time"];
        let with = ["--steadiness-pairs", "2", "--front", "front.toml", "--budget", budget, "-o", name, "--json"];
        place.json(&[&bench[..], &with].concat())["runs"][0].clone()
    };
    // No frame is so fast, so the cheapest setting is taken at once, and kept.
    let short = fly("0.01", "short");
    let governed = &short["governed"];
    assert_eq!(governed["held"], 0.0, "{governed}");
    assert_eq!((&governed["changes"][0]["to"], &governed["changes"][0]["reason"]), (&0.into(), &"panic".into()));
    assert_eq!(governed["changes"].as_array().unwrap().len(), 1, "{governed}");
    assert_eq!(short["allowed_error_px"]["p50"], 32.0, "{short}");
    // All frames are within a long budget, so the most exact setting is reached and kept.
    let long = fly("10000", "long");
    let governed = &long["governed"];
    assert_eq!(governed["held"], 1.0, "{governed}");
    let frames: Vec<u64> =
        governed["steps"].as_array().unwrap().iter().map(|it| it["frames"].as_u64().unwrap()).collect();
    assert!(frames[0] == 0 && frames[2] > frames[1], "{governed}");
    assert_eq!(long["allowed_error_px"]["p50"], 0.5, "{long}");
    for (arguments, cause) in [
        (&["--budget", "11"][..], "--real-time"),
        (&["--real-time", "--budget", "0"], "--budget"),
        (&["--real-time", "--budget", "11", "--styles", "plain"], "no measured settings"),
    ] {
        let line = ["bench", "dem.tif", "--path", "long.csv", "-o", "no"];
        let error = place.misuse(&[&line[..], arguments].concat());
        assert!(error.contains(cause), "{arguments:?}: {error}");
    }
}
