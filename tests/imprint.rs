//! Tests imprints, which record in a picture how it was drawn, and `render --like`, which draws a picture again.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

#[path = "../src/tests/common/program.rs"]
mod program;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use hachure::file::atomic;
use hachure::file::imprint::{self, Notes};
use hachure::file::png::{Picture, PngPixels, PngWriter, read_rgba8, write_rgba8};
use hachure::file::video::VideoWriter;
use hachure::internals::Imprint;
use program::full;

/// A folder with a DEM of a hill, `hill.asc`, which the program draws quickly.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.hill("hill.asc", 1.0);
        place
    }

    fn hill(&self, name: &str, height: f64) {
        let mut text = "ncols 96\nnrows 96\nxllcorner 0\nyllcorner 0\ncellsize 30\n".to_owned();
        for row in 0..96 {
            let height_m = |column: i32| {
                let (x, y) = (f64::from(column) / 14.0, f64::from(row) / 17.0);
                height * (400.0 + 300.0 * (x.sin() * y.cos()) + 60.0 * (3.1 * x + y).sin())
            };
            let heights: Vec<String> = (0..96).map(|column| format!("{:.2}", height_m(column))).collect();
            text += &(heights.join(" ") + "\n");
        }
        self.write(name, &text);
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        atomic::write(&self.path(name), text.as_bytes()).unwrap();
    }

    fn run(&self, arguments: &str) -> Output {
        program::run(self.0.path(), arguments)
    }

    fn draw(&self, arguments: &str) {
        program::draw(self.0.path(), arguments);
    }

    /// Returns the picture that these arguments draw.
    fn drawn(&self, arguments: &str) -> Picture {
        self.draw(&format!("{arguments} -o drawn.png"));
        self.read("drawn.png")
    }

    fn read(&self, name: &str) -> Picture {
        read_rgba8(&self.path(name)).unwrap()
    }

    /// Returns the one line of error with which the program fails.
    fn refused(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.trim_end().lines().count() == 1, "{arguments}: {said}");
        said
    }

    fn text(&self, name: &str) -> String {
        imprint::read(&self.path(name)).unwrap()
    }

    /// Writes a picture of one pixel with this imprint.
    fn say(&self, name: &str, text: &str) {
        let notes = Notes { imprint: Some(text), ..Notes::default() };
        let mut writer = PngWriter::create_noted(&self.path(name), 1, 1, PngPixels::Rgba8, &notes).unwrap();
        writer.write_rows(&[0; 4]).unwrap();
        writer.finish().unwrap();
    }
}

const VIEW: &str = "hill.asc --size 128x72 --camera=0,-1600,+300,4,-9,50";

#[test]
fn pictures_are_drawn_again() {
    let place = Place::new();
    // A custom style with custom marks; both change after the picture was drawn.
    let preset = hachure::style::preset_text("pencil").unwrap();
    let at = preset.find("marks = \"").unwrap() + 9;
    let end = at + preset[at..].find('"').unwrap();
    place.write("mine.toml", &format!("{}marks.toml{}", &preset[..at], &preset[end..]));
    let marks = "description = \"d\"\nkind = \"dash\"\nside_px = 64\nlength_px = 21\n";
    place.write("marks.toml", marks);
    let styles = ["--style mine.toml", "--style ink --dpi 150", "--style strokes --sun 100,20"];
    for arguments in styles.into_iter().take(if full() { 3 } else { 1 }) {
        place.draw(&format!("{VIEW} {arguments} -o before.png"));
        place.write("marks.toml", &marks.replace("dash", "stipple"));
        let again = place.drawn("--like before.png");
        assert!(again == place.read("before.png"), "{arguments}");
        // The new picture has the same imprint.
        assert_eq!(place.text("drawn.png"), place.text("before.png"));
        place.write("marks.toml", marks);
    }
    // Planted: another imprint gives another picture.
    place.draw(&format!("{VIEW} --style mine.toml --sun 100,20 -o before.png"));
    let (before, text) = (place.read("before.png"), place.text("before.png"));
    let words = [
        ("length_px = 21.0", "length_px = 11.0"),
        ("0,-1600,+300,4,-9,50", "0,-1600,+300,14,-9,50"),
        ("100,20", "200,20"),
    ];
    for (word, other) in words.into_iter().take(if full() { 3 } else { 1 }) {
        assert!(text.contains(word), "{word} is not in {text}");
        place.say("planted.png", &text.replacen(word, other, 1));
        assert!(place.drawn("--like planted.png") != before, "{other}");
    }
    place.say("planted.png", &text);
    assert!(place.drawn("--like planted.png") == before, "the imprint alone must determine the picture");
}

#[test]
fn every_format_says_it() {
    let place = Place::new();
    place.draw(&format!("{VIEW} --style strokes --sun=-60,30 -o a.png"));
    let (before, text) = (place.read("a.png"), place.text("a.png"));
    // Other formats are drawn again by `tests/commands/describe.rs`.
    for name in ["a.svg", "a.pdf", "a.exr", "a.jpg"].into_iter().take(if full() { 4 } else { 2 }) {
        place.draw(&format!("{VIEW} --style strokes --sun=-60,30 -o {name}"));
        assert_eq!(place.text(name), text, "{name}");
        assert!(place.drawn(&format!("--like {name}")) == before, "{name}");
    }
    // An editor may break lines and move attributes.
    let svg = fs::read_to_string(place.path("a.svg")).unwrap();
    let edited = svg.replace("<metadata id=\"hachure\">", "<metadata\n   inkscape:x='1'\n   id=\"hachure\">");
    assert_ne!(edited, svg);
    place.write("edited.svg", &edited);
    assert_eq!(place.text("edited.svg"), text);
    // The imprint has no path that was not given by the user, and no secrets of an address.
    let folder = place.0.path().to_string_lossy().into_owned();
    assert!(!text.contains(&folder) && text.contains("world = \"hill.asc\""), "{text}");
    let address = Imprint::parse("a.png", &text).unwrap();
    let address = Imprint { world: Some("https://me:word@a.org/x.tif?key=1".into()), ..address };
    assert!(address.text().contains("world = \"https://a.org/x.tif\""), "{}", address.text());
}

#[test]
fn arguments_come_before_the_picture() {
    let place = Place::new();
    place.hill("flat.asc", 0.3);
    let (style, other) = if full() { ("ink", "strokes") } else { ("lsa", "plain") };
    place.draw(&format!("{VIEW} --style {style} --sun 100,20 -o a.png"));
    let (hill, flat) = (format!("hill.asc --style {style}"), format!("flat.asc --style {style}"));
    let finer = format!("--dpi 192 --style {other}");
    let camera = "--camera=0,-1600,+300,4,-9,50";
    for (arguments, same) in [
        ("--sun 250,30", format!("{VIEW} --style {style} --sun 250,30")),
        ("--size 96x96", format!("{hill} {camera} --size 96x96 --sun 100,20")),
        ("flat.asc", format!("{flat} {camera} --size 128x72 --sun 100,20")),
        // A higher resolution gives more pixels of the same print.
        (finer.as_str(), format!("hill.asc {camera} --size 256x144 --sun 100,20 {finer}")),
        (
            "--date 2003-10-17T12:30:30-07:00 --place 39.742476,-105.1786",
            format!("{VIEW} --style {style} --sun 194.3,39.9"),
        ),
        (
            "--camera=300,-1500,+500,0,-20,50",
            format!("{hill} --camera=300,-1500,+500,0,-20,50 --size 128x72 --sun 100,20"),
        ),
        ("--style wash", format!("{VIEW} --style wash --sun 100,20")),
    ]
    .into_iter()
    .take(if full() { 7 } else { 5 })
    {
        let (like, direct) = (place.drawn(&format!("--like a.png {arguments}")), place.drawn(&same));
        if arguments.contains("--date") {
            let far = like.rgba.iter().zip(&direct.rgba).filter(|(a, b)| a.abs_diff(**b) > 24).count();
            assert!(far * 100 < like.rgba.len(), "{arguments}: {far}");
            continue;
        }
        assert!(like == direct, "{arguments}");
        assert!(like != place.read("a.png"), "{arguments}: the arguments must change the picture");
    }
}

#[test]
fn what_says_nothing_is_refused_in_a_line() {
    let place = Place::new();
    place.draw(&format!("{VIEW} -o a.png"));
    let text = place.text("a.png");
    write_rgba8(&place.path("bare.png"), 1, 1, &[0; 4]).unwrap();
    let bytes = fs::read(place.path("a.png")).unwrap();
    atomic::write(&place.path("cut.png"), &bytes[..400]).unwrap();
    let mut broken = bytes;
    let at = broken.windows(7).position(|window| window == b"version").unwrap();
    broken[at] ^= 1;
    atomic::write(&place.path("broken.png"), &broken).unwrap();
    let (version, keys) = text.split_once('\n').unwrap();
    assert!(version.starts_with("version = "), "{version}");
    place.say("newer.png", &format!("version = 999\nnews = 3\n{keys}"));
    place.say("other.png", &text.replacen("camera = \"", "camera = \"x", 1));
    place.say("key.png", &format!("glow = 3\n{text}"));
    place.say("style.png", &text.replacen("wrap = 0.4", "wrap = 9.0", 1));
    place.say("gone.png", &text.replace("hill.asc", "gone.asc"));
    place.say("net.png", &text.replace("hill.asc", "https://127.0.0.1:1/x.tif"));
    place.write("words.png", "words");
    place.write("cut.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"><metadata id=\"hachure\">version = 1\n");
    place.write("bare.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"><metadata>x</metadata></svg>");
    for (name, cause) in [
        ("bare.png", "it has no imprint that says how it was drawn"),
        ("cut.png", "unexpected end"),
        ("broken.png", ""),
        ("newer.png", "its imprint has version 999, this hachure reads up to "),
        ("other.png", "camera"),
        ("key.png", "unknown key \"glow\""),
        ("style.png", "light.wrap"),
        ("gone.png", "its world gone.asc: there is no such file; name it: hachure render WORLD --like gone.png"),
        ("net.png", "--trust-scene allows it"),
        ("words.png", "it is not a PNG, JPEG, EXR, SVG, PDF, GeoTIFF, GIF or MP4"),
        ("none.png", ""),
        ("cut.svg", "its metadata is truncated"),
        ("bare.svg", "it has no imprint that says how it was drawn"),
    ] {
        let said = place.refused(&format!("--like {name} -o x.png"));
        assert!(said.contains(name) && said.contains(cause), "{name}: {said}");
        assert!(!place.path("x.png").exists());
    }
    assert!(place.refused("--like a.png -o a.png").contains("does not overwrite its inputs"));
}

#[test]
fn paper_and_dots_make_pixels() {
    let place = Place::new();
    let camera = "hill.asc --camera=0,-1600,+300,4,-9,50";
    let style = if full() { "ink" } else { "plain" };
    for (arguments, size) in [
        ("--paper a6 --dpi 50", [291, 207]),
        ("--paper a6 --dpi 50 --portrait", [207, 291]),
        ("--paper letter --dpi 20", [220, 170]),
        ("--paper 25.4x12.7 --landscape", [300, 150]),
    ] {
        let picture = place.drawn(&format!("{camera} --style {style} {arguments}"));
        assert_eq!([picture.width, picture.height], size, "{arguments}");
    }
    let bytes = fs::read(place.path("drawn.png")).unwrap();
    let at = bytes.windows(4).position(|window| window == b"pHYs").unwrap() + 4;
    // 300 dots per inch are 11811 per metre; the last byte is the unit.
    assert_eq!(&bytes[at..at + 9], &[0, 0, 0x2e, 0x23, 0, 0, 0x2e, 0x23, 1]);

    // The widest stroke has the same width on paper at any resolution; with a constant number of pixels it would be a
    // third as wide.
    let widest = |dpi: u32| {
        place.draw(&format!("{camera} --style strokes --paper 120x80 --margin 5 --dpi {dpi} -o a.svg"));
        let text = fs::read_to_string(place.path("a.svg")).unwrap();
        assert!(text.contains("width=\"120mm\" height=\"80mm\""));
        let widths =
            text.split("stroke-width=\"").skip(1).map(|rest| rest.split_once('"').unwrap().0.parse::<f64>().unwrap());
        widths.fold(0.0, f64::max)
    };
    let (screen, print) = (widest(96), widest(if full() { 288 } else { 160 }));
    assert!((0.9..1.1).contains(&(print / screen)), "{screen} mm, {print} mm");
    // Without paper, the picture's own size is given in millimetres.
    place.draw(&format!("{camera} --style strokes --size 254x127 --dpi 254 -o a.svg"));
    let text = fs::read_to_string(place.path("a.svg")).unwrap();
    assert!(text.contains("width=\"25.4mm\" height=\"12.7mm\""), "{}", &text[..400]);

    for (arguments, cause) in [
        ("--paper a4 --size 100x100 -o x.png", "--size: cannot be combined with --paper"),
        ("--portrait -o x.png", "--portrait: requires --paper"),
        ("--paper a9 -o x.png", "--paper \"a9\""),
        ("--paper 99999x10 --dpi 10000 -o x.png", "each side must be 1 to 1048576"),
        ("--dpi 0 -o x.png", "--dpi"),
        ("--dpi 300 -o x.mp4 --path tour", "a film has no paper"),
        ("--style strokes --paper a5 --portrait -o x.svg", "without --dpi"),
    ] {
        let said = place.refused(&format!("hill.asc {arguments}"));
        assert!(said.contains(cause), "{arguments}: {said}");
    }
}

/// Tests that a film's imprint is passed to ffmpeg as a tag, with an option that keeps it.
#[cfg(unix)]
#[test]
fn a_film_says_it_through_ffmpeg() {
    let place = Place::new();
    let fake = place.path("ffmpeg");
    // A film of one frame, as small as one can be.
    let film = "\\000\\000\\000\\020ftypisom\\000\\000\\000\\000\\000\\000\\000\\074moov\\000\\000\\000\\064trak\\000\\000\\000\\054mdia\
        \\000\\000\\000\\044minf\\000\\000\\000\\034stbl\\000\\000\\000\\024stsz\\000\\000\\000\\000\\000\\000\\000\\001\\000\\000\\000\\001\
        \\000\\000\\000\\010mdat";
    let script = format!(
        "#!/bin/sh\nprintf '%s|' \"$@\" >\"$(dirname \"$0\")/arguments\"\ncat >/dev/null\nfor last; do :; done\n\
         printf '{film}' >\"${{last#file:}}\"\n"
    );
    // Another process writes the script, as in `src/tests/files.rs`.
    let write = "printf '%s' \"$1\" >\"$0\" && chmod 755 \"$0\"";
    assert!(Command::new("sh").arg("-c").arg(write).arg(&fake).arg(&script).status().unwrap().success());
    let arguments = |notes: &Notes<'_>| {
        let path = place.path("a.mp4");
        let mut film = VideoWriter::create_noted(fake.as_os_str(), &path, [2, 2], 24.0, notes).unwrap();
        film.write_frame(&[0; 16]).unwrap();
        film.finish().unwrap();
        fs::read_to_string(place.path("arguments")).unwrap()
    };
    let said = arguments(&Notes { imprint: Some("version = 1\nstyle = \"\""), ..Notes::default() });
    assert!(said.contains("|-metadata|hachure=version = 1\nstyle = \"\"|"), "{said}");
    assert!(said.contains("use_metadata_tags"), "{said}");
    assert!(!arguments(&Notes::default()).contains("metadata"));
}

#[test]
fn frames_and_holes_are_drawn_again() {
    let place = Place::new();
    // Land with a hole that --voids fill closes.
    let text = fs::read_to_string(place.path("hill.asc")).unwrap();
    let lines = text.lines().enumerate().map(|(number, line)| match number {
        44..50 => line
            .split(' ')
            .enumerate()
            .map(|(at, word)| if (40..52).contains(&at) { "-9999" } else { word })
            .collect::<Vec<_>>()
            .join(" "),
        4 => format!("{line}\nNODATA_value -9999"),
        _ => line.to_owned(),
    });
    place.write("holes.asc", &lines.collect::<Vec<_>>().join("\n"));
    let view = "holes.asc --size 64x36 --style plain --camera=0,-900,+900,0,-45,50";
    let filled = place.drawn(view);
    place.draw(&format!("{view} --voids holes -o before.png"));
    assert!(place.read("before.png") != filled, "the option must matter");
    assert!(place.drawn("--like before.png") == place.read("before.png"));
    assert!(place.text("before.png").contains("version = 4"));

    place.write("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,-900,+900,0,-45,50\n0.5,90,-900,+900,5,-45,50\n");
    let style = if full() { "ink" } else { "lsa" };
    let path = format!("holes.asc --size 64x36 --style {style} --path p.csv --fps 4 --antialias temporal");
    place.draw(&format!("{path} -o a%d.png"));
    place.draw("--like a0.png -o b%d.png");
    place.draw(&format!("{} -o c%d.png", path.replace(" --antialias temporal", "")));
    for number in 0..3 {
        let [a, b, c] = ["a", "b", "c"].map(|name| place.read(&format!("{name}{number}.png")));
        assert!(a == b, "frame {number}");
        assert!(number == 0 || a != c, "the option must matter");
    }
    // A single picture has no frames before it, and says so.
    let said = String::from_utf8(place.run("--like a1.png -o x.png").stderr).unwrap();
    assert!(said.contains("--antialias"), "{said}");
    assert!(place.refused("--like a1.png --camera=0,0,+9,0,0,50 -o x%d.png").contains("--camera: its path has"));
}

/// Tests the options that an imprint leaves out because the picture does not depend on them.
#[test]
fn what_an_imprint_leaves_out_does_not_change_the_picture() {
    let place = Place::new();
    let style = if full() { "ink" } else { "plain" };
    let view = format!("hill.asc --style {style} --size 160x90 --dpi 30 --camera=0,-1600,+300,4,-9,50");
    let plain = place.drawn(&view);
    place.draw(&format!(
        "{view} --json --trust-scene -v --sheets a6 --sheets-overlap 3 --sheets-margin 4 --tile-memory 700 -o s.png"
    ));
    assert!(place.read("s.png") == plain);
    assert!(place.drawn(&view.replace("+300", "+310")) != plain, "planted: another camera");
    place.draw(&format!("{view} -o a.exr"));
    place.draw(&format!("{view} --aov depth --aov-names standard -o b.exr"));
    let [a, b] = ["a.exr", "b.exr"].map(|name| hachure::file::exr::read_exr(&place.path(name)).unwrap());
    for channel in a.channels {
        let found = b.channels.iter().any(|other| other.name == channel.name && other.samples == channel.samples);
        assert!(found, "{}", channel.name);
    }
}

/// Tests that the words of a file that an imprint names are not printed, since whoever made the picture may not be
/// allowed to read it.
#[test]
fn an_imprint_shows_nothing_of_other_files() {
    let place = Place::new();
    let secret = "root:*:20228:0:99999\nsecond:$6$word\n";
    place.write("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,-900,+900,0,-45,50\n1,9,-900,+900,0,-45,50\n");
    place.draw(&format!("{VIEW} --style plain --water lake.geojson -o a.png").replace("--water lake.geojson ", ""));
    place.draw("hill.asc --size 64x36 --style plain --path p.csv --fps 1 -o f%d.png");
    let (text, frame) = (place.text("a.png"), place.text("f0.png"));
    let is_quoted = |said: &str| ["root", "second", "20228", "word"].iter().any(|word| said.contains(word));
    let names = ["x", "x.toml", "x.asc", "x.csv", "x.geojson", "x.tif", "x.xyz", "x.obj", "x.dem", "x.hdr"];
    // The last command below reads `x.csv`.
    for name in names.into_iter().take(if full() { 10 } else { 5 }) {
        place.write(name, secret);
        for (key, imprint) in [
            ("world", text.replace("world = \"hill.asc\"", &format!("world = \"{name}\""))),
            ("water", format!("{text}\n[more]\nwater = \"{name}\"\n")),
            ("path", frame.replace("path = \"p.csv\"", &format!("path = \"{name}\""))),
            ("style", text.replace("style = \"\"\"", &format!("style = \"{name}\"\nold = \"\"\""))),
        ] {
            assert!(imprint != text && imprint != frame, "{key}");
            place.say("like.png", &imprint);
            let output = place.run(&format!("--like like.png -o x{}.png", if key == "path" { "%d" } else { "" }));
            let said = String::from_utf8(output.stderr).unwrap();
            let is_refused =
                !output.status.success() && said.lines().last().is_some_and(|line| line.contains("like.png"));
            assert!(!is_quoted(&said) && is_refused, "{key} {name}: {said}");
        }
    }
    // Named on the command line, the file is quoted: whoever types its name can read it.
    assert!(is_quoted(&place.refused("hill.asc --path x.csv -o y%d.png")));
}

/// Tests that a text that is compressed to nothing is not inflated to more than an imprint may have.
#[test]
fn a_compressed_imprint_is_inflated_up_to_a_limit() {
    let place = Place::new();
    place.draw(&format!("{VIEW} --style plain -o a.png"));
    let text = place.text("a.png");
    let with = |text: String| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
        encoder.set_color(png::ColorType::Rgba);
        let mut chunk = png::text_metadata::ITXtChunk::new("hachure", text);
        chunk.compressed = true;
        let mut writer = encoder.write_header().unwrap();
        writer.write_text_chunk(&chunk).unwrap();
        writer.write_image_data(&[0; 4]).unwrap();
        writer.finish().unwrap();
        atomic::write(&place.path("z.png"), &bytes).unwrap();
        bytes.len()
    };
    with(text.clone());
    assert_eq!(place.text("z.png"), text);
    assert!(with("#".repeat(8 << 20)) < 100_000);
    let error = imprint::read(&place.path("z.png")).unwrap_err().to_string();
    assert!(error.contains("larger than 4 MiB"), "{error}");
    place.say("z.png", &"#".repeat((4 << 20) + 1));
    assert!(imprint::read(&place.path("z.png")).unwrap_err().to_string().contains("larger than 4 MiB"));
}
