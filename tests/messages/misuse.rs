//! Tests arguments that are rejected.

use std::fs;

use crate::Place;

#[test]
fn misuse_gives_an_error_of_one_line() {
    let place = Place::new();
    place.file("x.tif", "junk");
    place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+9,0,0,50\n");
    let render = ["render", "-o", "o.png"];
    let svg = ["render", "-o", "o.svg", "--style", "strokes"];
    let bench = ["bench", "--path", "p.csv", "-o", "out"];
    let cases: &[(&[&str], &[&str], &[&str])] = &[
        // Invalid values.
        (&render, &["--fps", "0"], &["--fps", "\"0\"", "above 0"]),
        (&render, &["--fps", "-3"], &["--fps", "\"-3\""]),
        (&render, &["--fps", "fast"], &["--fps", "\"fast\"", "number"]),
        (&render, &["--fps", "1e9"], &["at most 1000"]),
        (&render, &["--lod-error", "0"], &["--lod-error", "above 0"]),
        (&render, &["--lod-error", "nan"], &["--lod-error", "\"nan\""]),
        (&render, &["--size", "10"], &["--size", "1280x720"]),
        (&render, &["--camera", "1,2"], &["--camera", "x,y,z,yaw,pitch,fov"]),
        (&render, &["--camera", "1,2,here,4,5,6"], &["z is `here`"]),
        (&render, &["--tile-memory", "0"], &["--tile-memory", "1 to 1048576"]),
        (&render, &["--tile-memory", "lots"], &["whole number"]),
        (&render, &["--eyes", "three"], &["--eyes", "mono"]),
        (&render, &["--eyes", "anaglif"], &["did you mean \"anaglyph\"?"]),
        (&render, &["--voids", "hole"], &["did you mean \"holes\"?"]),
        (&render, &["--encoding", "terarium"], &["did you mean \"terrarium\"?"]),
        (&render, &["--antialias", "temporl"], &["did you mean \"temporal\"?"]),
        (&["list"], &[], &["did you mean \"hachure styles list\"?"]),
        (&["styles", "migrat"], &[], &["did you mean \"migrate\"?"]),
        (&render, &["--aov", "depth"], &["--aov", ".exr", "o.png"]),
        (&["render", "-o", "o.exr"], &["--aov", "dept"], &["--aov dept", "did you mean \"depth\"?"]),
        (&["render", "-o", "o.exr"], &["--aov", "lsa", "--style", "plain"], &["--aov lsa", "plain"]),
        (&["render", "-o", "o.svg"], &["--show", "depth", "--style", "strokes"], &["--show", ".png", "o.svg"]),
        (&render, &["--show", "depth", "--aov", "depth"], &["--show", "--aov"]),
        (&svg, &["--paper", "a9"], &["--paper", "\"a9\"", "a4"]),
        (&svg, &["--paper", "a4", "--margin", "-1"], &["--margin", "\"-1\""]),
        (&svg, &["--paper", "a4", "--margin", "200"], &["--margin 200"]),
        (&svg, &["--tolerance-px", "0"], &["--tolerance-px", "0.01"]),
        (&render, &["--margin", "4"], &["--margin", ".svg"]),
        (&render, &["--set", "strokes.widht_px=2"], &["--set", "strokes.widht_px; did you mean \"strokes.width_px\"?"]),
        (&render, &["--set", "qqqq=1"], &["no parameter qqqq; hachure styles show NAME --all lists the keys"]),
        (&render, &["--style", "inc"], &["inc: no such style; did you mean \"ink\"?"]),
        (&render, &["--style", "oil"], &["oil: no such style", "hachure styles"]),
        (&render, &["--style"], &["--style", "needs a value"]),
        (&bench, &["--styles", "ink,oil"], &["oil: no such style"]),
        (&bench, &["--lod-error", "-1"], &["--lod-error"]),
        (&bench, &["--swoop", "size"], &["\"--swoop\"", "hachure bench --help"]),
        (&bench, &["--sweep", "size"], &["--sweep", "KEY=VALUE"]),
        (&bench, &["--frames", "0"], &["--frames", "1 to 1000000"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--max-error", "-1"], &["--max-error", "\"-1\""]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--shard", "3/2"], &["--shard", "3/8"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--spacing", "0"], &["--spacing", "above 0"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--raw-size", "3"], &["--raw-size"]),
        (&["styles", "show"], &["pencl"], &["did you mean \"pencil\"?"]),
        // Samples and anti-aliasing.
        (&render, &["--samples", "0"], &["--samples", "1 to 1024"]),
        (&render, &["--antialias", "fxaa"], &["--antialias", "none or temporal"]),
        (&render, &["--antialias", "temporal"], &["--antialias temporal", "--path", "--samples"]),
        (
            &["render", "-o", "o%d.png", "--path", "p.csv", "--antialias", "temporal"],
            &["--samples", "4"],
            &["--antialias temporal", "--samples"],
        ),
        (
            &["render", "-o", "o%d.png", "--path", "p.csv", "--antialias", "temporal"],
            &["--size", "9000x1000"],
            &["--antialias temporal", "--size", "parts"],
        ),
        (
            &["render", "-o", "o%d.exr", "--path", "p.csv", "--antialias", "temporal"],
            &["--aov", "depth"],
            &["--antialias temporal", "--aov"],
        ),
        (
            &["render", "-o", "o%d.svg", "--path", "p.csv", "--style", "strokes"],
            &["--antialias", "temporal"],
            &["--antialias temporal", ".svg"],
        ),
        (&render, &["--date", "2026-06-21"], &["\"2026-06-21\": it must be", "2026-06-21T07:30Z"]),
        (&render, &["--place", "46,8"], &["--place: requires --date, which is not given"]),
        (&render, &["--size", "99999999x10"], &["each side must be", "1048576"]),
        (&render, &["--size", "1048576x1048576"], &["it must have at most 17179869184 pixels"]),
        (&render, &["--fps", "25"], &["--fps: applies to the frames of a --path, and o.png is one picture"]),
        (&render, &["--map", "x.tif"], &["--map took \"x.tif\" as its value; put the DEM before --map"]),
        (&render, &["--map", "0,0,9", "--camera", "0,0,9,0,0,50"], &["--map and --camera cannot be used together"]),
        (&render, &["--spacing", "2"], &["--spacing is an option of hachure bake; for hachure render set spacing_m"]),
        (&["info", "x.tif"], &["--raw-size", "9x9"], &["is an option of hachure bake; for hachure info set width"]),
        (&render, &["none"], &["none: there is no such file"]),
        (&render, &["hutt"], &["hutt: there is no such file", "did you mean \"hut\"?"]),
        (&render, &["continentt"], &["continentt: there is no such file", "did you mean \"continent\"?"]),
        (&["render", "-o", "o.mp4"], &["--path", "tuor"], &["the built-in paths are", "did you mean \"tour\"?"]),
        (&["bench", "-o", "out"], &["--path", "nopath"], &["nopath", "the built-in paths are ascent, "]),
        (&["render", "-o", "o.gif"], &["--path", "tour", "--fps", "60"], &["--fps 60: a GIF shows at most 50"]),
        (&["render", "-o", "o.glb"], &["--size", "9x9"], &["--size: sets the shape of --map for a mesh; add --map="]),
        (&["render", "-o", "o%03d.gif"], &["--path", "tour"], &["o%03d.gif: a GIF holds the whole film; leave out"]),
        // Output names.
        (&["render", "x.tif"], &["-o", "o.gif"], &["o.gif", ".png"]),
        (&["render", "x.tif"], &["-o", "o"], &["o: it must end in .png"]),
        (&["render", "x.tif"], &["-o", "%x.png", "--path", "p.csv"], &["%x.png", "%05d"]),
        (&["bake", "x.tif"], &["-o", "o.png"], &["o.png", ".tif"]),
        // A single picture or several.
        (&["render", "x.tif"], &["-o", "o.mp4"], &["o.mp4", "--path"]),
        (&["render", "x.tif"], &["-o", "o%04d.png"], &["o%04d.png", "--path"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.png"], &["o.png", "%05d.png", "--camera"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.exr"], &["o.exr", "%05d.png"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.svg", "--style", "strokes"], &["o.svg", "%05d.png"]),
        (&["x.tif"], &["-o", "o.mp4"], &["-o", "hachure render"]),
        // Commands.
        (&["rendr"], &["x.tif"], &["\"rendr\"", "did you mean \"render\"?"]),
        (&["rendr"], &["x.tif", "-o", "o.png"], &["did you mean \"render\"?"]),
        (&["rendr"], &[], &["did you mean \"render\"?"]),
        (&["-v", "rendr"], &["x.tif"], &["did you mean \"render\"?"]),
        (&["--adapter", "software", "rendr"], &["x.tif"], &["did you mean \"render\"?"]),
        (&["help"], &["rendr"], &["did you mean \"render\"?"]),
        (&["x.tif"], &["y.tif"], &["unexpected argument \"y.tif\""]),
        (&["styles"], &["chekc"], &["did you mean \"check\"?"]),
        (&["info"], &[], &["<FILE>", "missing"]),
        (&["info", "a.tif"], &["b.tif"], &["unexpected argument \"b.tif\""]),
        (&["bake", "-o", "y.tif"], &["https://me:hush@example.org/a.tif"], &["local files only"]),
        (&["bake"], &["https://example.org/a.tif", "-o", "o.tif"], &["local files only"]),
        (&["render"], &["x.tif"], &["--output", "missing"]),
        (&["bake"], &[], &["--output", "are missing"]),
        (&["render", "-o", "o.png"], &["--stile", "ink"], &["\"--stile\"", "--style"]),
        (&["render", "-o", "o.png"], &["--bogus"], &["\"--bogus\"; see hachure render --help"]),
        (&["render", "-o", "o.png"], &["--adaptr", "best"], &["\"--adaptr\"; did you mean --adapter?"]),
        (&["styles", "check"], &["ink"], &["ink is a preset", "hachure styles show ink"]),
        (&["render", "-o", "o.png"], &["-o", "p.png"], &["--output", "twice"]),
        (&["render", "-o", "o.mp4"], &["--path", "p.csv", "--camera", "0,0,9,0,0,50"], &["--path", "--camera"]),
        (&["--style", "ink", "render"], &["-o", "o.png"], &["--style", "hachure render"]),
        (&["--encoding", "terrarium", "info"], &["x.tif"], &["--encoding", "hachure info"]),
        (&["x.tif", "render"], &["-o", "o.png"], &["x.tif", "hachure render"]),
        (&["render", ""], &["-o", "o.png"], &["WORLD is empty"]),
    ];
    let output = place.hachure(&["render", "-o", "o.png", "--date", "2026-06-21"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("did you mean"), "an example is not a choice");
    for (start, rest, words) in cases {
        place.refused(&[*start, *rest].concat(), 2, words);
    }
    // Marks of the default style may be in the cache.
    let names = fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let left: Vec<_> = names.filter(|name| name != "cache").collect();
    assert_eq!(left.len(), 2, "nothing may have been written: {left:?}");
}

#[test]
fn options_of_all_commands_stand_anywhere() {
    let place = Place::new();
    place.file("s.toml", "[world]\nprocedural = { seed = 4 }\n");
    for arguments in [
        &["-v", "info", "s.toml"][..],
        &["info", "-v", "s.toml"],
        &["info", "s.toml", "-vv"],
        &["--adapter", "software", "info", "s.toml"],
        &["info", "--adapter", "software", "s.toml"],
        &["-v", "--adapter=software", "styles"],
    ] {
        let output = place.hachure(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    // Without a command, these options belong to `fly`, which requires a display or first opens its world.
    place.refused(&["-v", "none.tif"], 1, &["none.tif: there is no such file"]);
    place.refused(&["none.tif", "--adapter", "software", "-v"], 1, &["none.tif: there is no such file"]);
    place.refused(&["--adapter", "software", "render", "none.tif", "-o", "o.png"], 1, &["none.tif"]);
    let help = String::from_utf8(place.hachure(&["--help"]).stdout).unwrap();
    assert!(help.contains("hachure [OPTIONS] [WORLD]") && help.contains("hachure [OPTIONS] <COMMAND>"), "{help}");
}
