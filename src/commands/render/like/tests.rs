//! Every option of `render` is in the imprint, or does not change the picture.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

use std::collections::BTreeSet;

use clap::CommandFactory;

use super::*;
use crate::commands::arguments;
use crate::commands::render::paper;
use crate::commands::world_args::WorldArgs;

/// The effect of `--like` on an option.
enum Fate {
    /// The imprint contains it: the arguments of a picture with it.
    Kept(&'static str),
    /// It becomes another option, which the imprint contains.
    Becomes(&'static str),
    /// The picture does not depend on it; `tests/imprint.rs` draws with it and without.
    Unneeded,
}

use Fate::{Becomes, Kept, Unneeded};

/// Every option of `render` by its id. A new one has to be added here: it is kept, or does not change the picture.
const OPTIONS: &[(&str, Fate)] = &[
    ("world", Kept("other.tif -o a.png")),
    ("encoding", Kept("--encoding mapbox -o a.png")),
    ("height_scale", Kept("--height-scale 0.5 -o a.png")),
    ("height_offset", Kept("--height-offset=-3 -o a.png")),
    ("height_unit", Kept("--height-unit us-ft -o a.png")),
    ("tile_rows", Kept("--tile-rows tms -o a.png")),
    ("nodata", Kept("--nodata=-7.5 -o a.png")),
    ("voids", Kept("--voids holes -o a.png")),
    ("sun", Kept("--sun 100,20 -o a.png")),
    ("side_light", Becomes("sun")),
    ("date", Becomes("sun")),
    ("place", Becomes("sun")),
    ("focus", Kept("--focus 1,2,300,0.5 -o a.png")),
    ("haze", Kept("--haze 2500 -o a.png")),
    ("water", Kept("--water lake.geojson -o a.png")),
    ("layer", Kept("--layer a.gpx --layer b.gpkg -o a.png")),
    ("graticule", Kept("--graticule 0.5 -o a.png")),
    ("drape", Kept("--drape a.tif --drape b.png -o a.png")),
    ("exaggeration", Kept("--exaggeration 2.5 -o a.png")),
    ("sea_level", Kept("--sea-level=-2.5 -o a.png")),
    ("trees", Kept("--trees 7 -o a.png")),
    ("seed", Kept("--seed 2 -o a.png")),
    ("trust_scene", Unneeded),
    ("output", Unneeded),
    ("like", Unneeded),
    ("style", Kept("--style wash -o a.png")),
    ("quality", Becomes("set")),
    ("fronts", Becomes("set")),
    ("set", Kept("--set tone.steps=5 -o a.png")),
    ("size", Kept("--size 64x36 -o a.png")),
    ("dpi", Kept("--dpi 150 -o a.png")),
    ("camera", Kept("--camera=5,6,+7,8,9,50 -o a.png")),
    ("look_at", Becomes("camera")),
    ("from", Becomes("camera")),
    ("at", Becomes("map")),
    ("map_width", Becomes("map")),
    ("map", Kept("--map 10,20,3000 -o a.png")),
    ("path", Kept("--path p.csv -o a.mp4")),
    ("fps", Kept("--path p.csv --fps 12.5 -o a%d.png")),
    ("frames", Kept("--path p.csv --frames 3..7 -o a%d.png")),
    ("warm_up", Kept("--path p.csv --frames 3..7 --warm-up 5 -o a%d.png")),
    ("time_s", Kept("--time-s 2.5 -o a.png")),
    ("eyes", Kept("--eyes anaglyph -o a.png")),
    ("ipd", Kept("--eyes left --ipd auto -o a.png")),
    ("convergence", Kept("--eyes left --convergence 70 -o a.png")),
    ("tone_curve", Kept("--style crosshatch --tone-curve 0.2,0.9,3000 -o a.png")),
    ("samples", Kept("--samples 4 -o a.exr")),
    ("antialias", Kept("--path p.csv --antialias temporal -o a%d.png")),
    ("lod_error", Kept("--lod-error 0.5 -o a.png")),
    ("aov", Unneeded),
    ("aov_names", Unneeded),
    ("show", Kept("--show lsa -o a.png")),
    ("title", Kept("--title T -o a.svg")),
    ("credits", Kept("--title T --credits C -o a.png")),
    ("legend", Kept("--title T --legend -o a.png")),
    ("peaks", Kept("--peaks 7 -o a.png")),
    ("saddles", Kept("--map 10,20,3000 --saddles 4 -o a.png")),
    ("lakes", Kept("--map 10,20,3000 --lakes 3 -o a.png")),
    ("names", Kept("--names n.csv -o a.png")),
    ("name_layer", Kept("--names n.gpkg --name-layer peaks -o a.png")),
    ("name_when", Kept("--names n.csv --name-when ele>2 -o a.png")),
    ("name_field", Kept("--names n.csv --name-field title -o a.png")),
    ("map_scale", Kept("--map 10,20 --map-scale 1:50000 --dpi 100 -o a.png")),
    ("frame", Kept("--map 10,20,3000 --map-frame -o a.png")),
    ("tile_memory", Kept("--tile-memory 3 -o a.png")),
    ("tolerance_px", Kept("--tolerance-px 0.5 -o a.svg")),
    ("paper", Kept("--paper a5 -o a.svg")),
    ("landscape", Becomes("size")),
    ("portrait", Becomes("size")),
    ("margin", Kept("--paper a5 --margin 3 -o a.svg")),
    ("sheets", Unneeded),
    ("sheets_overlap", Unneeded),
    ("sheets_margin", Unneeded),
    ("pens", Kept("--pens 2 -o a.svg")),
    // A GeoJSON and a mesh have no imprint.
    ("wgs84", Unneeded),
    ("mesh_error", Unneeded),
    ("overwrite", Unneeded),
    ("json", Unneeded),
    // Of all commands. Another adapter rounds otherwise.
    ("adapter", Unneeded),
    ("verbose", Unneeded),
];

fn parsed(line: &str) -> RenderArgs {
    let words = ["hachure", "render"].into_iter().chain(line.split(' '));
    match Cli::try_parse_from(words).unwrap().command {
        Some(Command::Render(args)) => *args,
        _ => panic!("{line}"),
    }
}

/// Returns the drawing that the arguments describe, as text. Without `..`, so that a new option is not forgotten.
fn drawn(args: &RenderArgs) -> String {
    let RenderArgs {
        world: WorldArgs { name, heights, light, water, layers, land, exaggeration, trust_scene: _ },
        output: _,
        like: _,
        // A quality is a style and options, which are there themselves.
        quality: _,
        style: _,
        set: _,
        size: _,
        dpi,
        camera,
        look: _,
        map,
        map_scale,
        map_place: _,
        path,
        fps: _,
        frames,
        warm_up,
        wgs84: _,
        time_s,
        stereo,
        tone_curve,
        samples: _,
        antialias: _,
        lod_error: _,
        aov: _,
        aov_names: _,
        show,
        title,
        credits,
        legend,
        labels,
        saddles,
        lakes,
        frame,
        mesh_error: _,
        tile_memory: _,
        tolerance_px,
        paper,
        landscape: _,
        portrait: _,
        margin,
        sheets: _,
        pens,
        overwrite: _,
        json: _,
    } = args;
    let light = format!("{:?} {:?}", light.sun.unwrap_or_default(), (light.focus, light.haze));
    let world = format!("{name:?} {heights:?} {light} {water:?} {layers:?} {land:?} {exaggeration:?}");
    // The camera of frames is that of their path, and the similar one of a map is not used.
    let camera = camera.filter(|_| path.is_none() && map.is_none());
    let time_s = time_s.unwrap_or(0.0);
    let view =
        format!("{camera:?} {map:?} {map_scale:?} {path:?} {} {time_s} {stereo:?} {frames:?} {warm_up:?}", args.fps());
    let quality =
        format!("{tone_curve:?} {} {:?} {} {}", args.samples(), args.antialias(), args.lod_error(), args.tile_memory());
    let page = format!(
        "{:?} {dpi:?} {show:?} {title:?} {credits:?} {legend} {labels:?} {saddles:?} {lakes:?} {frame} {tolerance_px:?} {paper:?} {margin:?} {pens:?}",
        args.size()
    );
    format!("{world}\n{view}\n{quality}\n{page}")
}

/// Returns what a line draws, and what `--like` draws with its imprint; both with the style.
fn twice(line: &str) -> [String; 2] {
    let base = "w.tif --camera=0,0,+300,0,-5,50 ";
    let own = ["--camera", "--map", "--path"].iter().any(|option| line.contains(option));
    let base = if own { "w.tif " } else { base };
    let base = if line.starts_with("other.tif") { &base[6..] } else { base };
    let args = parsed(&format!("{base}{line}"));
    let kind = OutputKind::of(&args.output).unwrap();
    let args = paper::measured(&args, &kind).unwrap();
    let style = arguments::style_with("--set", args.style.as_deref().unwrap_or("ink"), &args.set).unwrap();
    let camera = args.camera.unwrap_or_else(|| "0,0,+300,0,-5,50".parse().unwrap());
    let text = text_at(&imprint(&args, &kind, &style, &camera), &camera, Clock::still(args.time_s.unwrap_or(0.0)));
    let read = Imprint::parse("a.png", &text).unwrap();
    let output = args.output.display();
    let all = with_imprint(&parsed(&format!("--like a.png -o {output}")), &kind, &read).unwrap();
    [drawn(&args) + &style.text(), drawn(&all) + &read.style.text()]
}

#[test]
fn every_option_is_in_the_imprint_or_does_not_change_the_picture() {
    let program = Cli::command();
    let of_program = program.get_arguments().filter(|argument| argument.is_global_set());
    let of_render = program.find_subcommand("render").unwrap().get_arguments().chain(of_program);
    let found: BTreeSet<&str> = of_render.map(|argument| argument.get_id().as_str()).collect();
    let known: BTreeSet<&str> = OPTIONS.iter().map(|(id, _)| *id).collect();
    assert_eq!(found, known, "an option of render is not in the list of this test");
    for (id, fate) in OPTIONS {
        match fate {
            Kept(line) => {
                let [args, again] = twice(line);
                assert_eq!(args, again, "{id}: --like draws something else");
                // Planted: the imprint of a picture without the option gives other arguments.
                let words: Vec<&str> = line.split(' ').collect();
                let output = words[words.len() - 1];
                let without = match *id {
                    "fps" | "antialias" | "frames" | "warm_up" => format!("--path p.csv -o {output}"),
                    "ipd" | "convergence" => format!("--eyes left -o {output}"),
                    "margin" => format!("--paper a5 -o {output}"),
                    "path" => "--path q.csv -o a.mp4".to_owned(),
                    _ => format!("-o {output}"),
                };
                assert_ne!(twice(&without)[1], args, "{id}: the option must matter");
            }
            Becomes(other) => assert!(known.contains(other), "{id}"),
            Unneeded => {}
        }
    }
    let portrait = "--paper a5 --dpi 50 --portrait -o a.svg";
    assert!(
        twice(portrait)[0] == twice(portrait)[1]
            && twice(portrait)[1] != twice(&portrait.replace("--portrait ", ""))[1]
    );
}

#[test]
fn numbers_of_an_imprint_have_the_ranges_of_the_command_line() {
    let args = parsed("w.tif --camera=0,0,+300,0,-5,50 -o a.png");
    let kind = OutputKind::of(&args.output).unwrap();
    let text = imprint(&args, &kind, &Style::load("plain").unwrap(), &args.camera.unwrap()).text();
    let with = |key: &str, value: &str| match key {
        "size" | "dpi" | "sun" | "camera" => {
            // Only the imprint's own key: the style has some of the same name.
            let own = text.lines().position(|line| line.starts_with(&format!("{key} = ")));
            let lines = text.lines().enumerate().filter(|(number, _)| Some(*number) != own);
            let lines: Vec<&str> = lines.map(|(_, line)| line).collect();
            Imprint::parse("a.png", &format!("{key} = {value}\n{}", lines.join("\n")))
        }
        _ => Imprint::parse("a.png", &format!("{text}\n[more]\n{key} = {value}\n")),
    };
    for (key, right, wrong) in [
        ("size", "[64, 36]", &["[0, 36]", "[64, 1048577]", "[64, -1]"][..]),
        ("dpi", "300.0", &["0.5", "nan", "inf", "10001.0"]),
        ("sun", "\"10,20\"", &["\"nan,20\"", "\"10,91\"", "\"10,inf\""]),
        ("camera", "\"0,0,10,0,0,50\"", &["\"0,0,nan,0,0,50\"", "\"0,0,10,0,0,0\"", "\"0,0,1e30,0,0,50\""]),
        ("time_s", "2.0", &["nan", "inf", "1e9"]),
        ("samples", "1024", &["0", "1025", "4294967295", "-1"]),
        ("lod_error", "0.5", &["0.0", "-1.0", "nan", "inf"]),
        ("nodata", "-9999.0", &["nan", "-inf"]),
        ("exaggeration", "1000.0", &["0.0", "-1.0", "nan", "inf", "1001.0"]),
        ("haze", "2500.0", &["0.0", "-1.0", "nan", "inf"]),
        ("seed", "4294967295", &["-1", "4294967296", "1.5"]),
        ("tile_memory", "1", &["0", "-1", "1048577"]),
        ("convergence", "5.0", &["0.0", "-1e300", "nan"]),
        ("margin", "0.0", &["-0.1", "nan", "1e6"]),
        ("tolerance_px", "0.5", &["0.0", "-1.0", "nan", "1e300"]),
        ("pens", "3", &["0", "4", "1000000000"]),
        ("fps", "1000.0", &["0.0", "inf", "1e300", "nan"]),
    ] {
        assert!(with(key, right).is_ok(), "{key} = {right}: {:?}", with(key, right));
        for value in wrong {
            let error = with(key, value).unwrap_err().to_string();
            assert!(error.contains(key) && !error.contains('\n'), "{key} = {value}: {error}");
        }
    }
    // Texts are parsed by the parsers of their options.
    for (key, wrong) in [
        ("voids", "deep"),
        ("focus", "1,2,nan"),
        ("map", "0,0,nan"),
        ("encoding", "x"),
        ("eyes", "three"),
        ("antialias", "much"),
        ("sea_level", "9001"),
        ("trees", "-1"),
    ] {
        let read = with(key, &format!("\"{wrong}\"")).unwrap();
        let error = with_imprint(&parsed("--like a.png -o b.png"), &kind, &read).unwrap_err();
        let error = crate::file::message::chain(error.as_ref());
        assert!(error.contains(key) || key == "encoding", "{key}: {error}");
    }
    // A seed is that of the picture's world, and other land may have none.
    let seeded = with("seed", "2").unwrap();
    for (line, seed) in [("--like a.png -o b.png", Some(2)), ("own.tif --like a.png -o b.png", None)] {
        assert_eq!(with_imprint(&parsed(line), &kind, &seeded).unwrap().world.land.seed, seed, "{line}");
    }
    let read = with("ipd", "\"-1\"\neyes = \"left\"").unwrap();
    assert!(with_imprint(&parsed("--like a.png -o b.png"), &kind, &read).is_err());
}

/// The export dialog of a window shows a command line; its options must be those of the picture.
#[cfg(feature = "window")]
#[test]
fn the_options_of_an_exported_view_are_those_of_its_imprint() {
    use crate::studio::export::view_arguments;
    // What only some outputs have is not in the imprint of a window.
    let of_outputs = [
        "style",
        "set",
        "size",
        "dpi",
        "paper",
        "margin",
        "tolerance_px",
        "pens",
        "show",
        "path",
        "fps",
        "frames",
        "warm_up",
    ];
    let parse = |id: &str, words: Vec<String>| {
        let words = ["hachure", "render"].into_iter().map(str::to_owned).chain(words);
        let cli = Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{id}: {error}"));
        let Some(Command::Render(args)) = cli.command else { panic!("{id}") };
        let kind = OutputKind::of(&args.output).unwrap();
        let camera = args.camera.unwrap_or(crate::scene::path::CameraPath::ORIGIN);
        let mut imprint = imprint(&args, &kind, &Style::load("ink").unwrap(), &camera);
        imprint.more.time_s = args.time_s;
        // A map has no camera of its own.
        let camera = imprint.more.map.is_none().then_some(imprint.camera);
        (imprint.world.clone(), imprint.sun, camera, imprint.more.clone(), imprint)
    };
    let mut compared = 0;
    for (id, fate) in OPTIONS {
        let Kept(arguments) = fate else { continue };
        if of_outputs.contains(id) || arguments.contains("--path") {
            continue;
        }
        let given = parse(id, arguments.split_whitespace().map(str::to_owned).collect());
        let mut words = view_arguments(&given.4);
        words.push("-oa.png".to_owned());
        let again = parse(id, words.clone());
        assert!((&given.0, given.1, given.2, &given.3) == (&again.0, again.1, again.2, &again.3), "{id}: {words:?}");
        // Planted: without its option, the picture differs.
        let default = parse(id, vec!["-oa.png".to_owned()]);
        assert!((&given.0, given.1, given.2, &given.3) != (&default.0, default.1, default.2, &default.3), "{id}");
        compared += 1;
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn a_place_takes_the_scale_of_the_picture_or_its_width() {
    let liked = |of: &str, given: &str| {
        let args = parsed(&format!("w.tif --dpi 100 -o a.png {of}"));
        let kind = OutputKind::of(&args.output).unwrap();
        let camera = "0,0,+300,0,-5,50".parse().unwrap();
        let text = text_at(&imprint(&args, &kind, &Style::load("ink").unwrap(), &camera), &camera, Clock::default());
        let read = Imprint::parse("a.png", &text).unwrap();
        let all = with_imprint(&parsed(&format!("--like a.png -o b.png {given}")), &kind, &read).unwrap();
        (all.map.map(|map| map.to_string()), all.map_scale.map(|scale| scale.to_string()))
    };
    let text = |text: &str| Some(text.to_owned());
    assert_eq!(liked("--map 1,2 --map-scale 1:50000", "--map=30,40"), (text("30,40"), text("50000")));
    assert_eq!(liked("--map 1,2,3000", "--map=30,40"), (text("30,40,3000"), None));
    // Without a size on paper there is no scale.
    assert_eq!(liked("--map 1,2,3000 --map-scale 1:50000", "--map=30,40"), (text("30,40,3000"), None));
    assert_eq!(liked("--map 1,2,3000 --map-scale 1:50000", "--dpi 100 --map=30,40"), (text("30,40"), text("50000")));
    // What is given counts.
    assert_eq!(liked("--map 1,2 --map-scale 1:50000", "--map=30,40,700"), (text("30,40,700"), None));
    assert_eq!(liked("--map 1,2,3000", "--map=30,40 --map-scale 1:25000"), (text("30,40"), text("25000")));
}
