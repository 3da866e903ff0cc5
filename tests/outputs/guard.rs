//! Tests that an input is never overwritten by an output, under whatever name.

use hachure::internals::members;

use crate::place::{PATH, Place, changed, full, has_gpu};

/// Returns a folder that contains a folder of two DEMs.
fn place_with_folder() -> Place {
    let place = Place::empty();
    place.geotiff("dems/a.tif", 0);
    place.geotiff("dems/more/b.tif", 50);
    place
}

#[test]
fn a_change_of_a_file_is_seen() {
    let place = place_with_folder();
    let before = place.files();
    assert_eq!(changed(&before, &place.files()).len(), 0);
    let mut bytes = std::fs::read(place.path("dems/a.tif")).unwrap();
    bytes[200] ^= 1;
    place.file("dems/a.tif", bytes);
    place.file("new.txt", "");
    assert_eq!(changed(&before, &place.files()), [place.path("dems/a.tif"), place.path("new.txt")]);
}

#[test]
fn a_bake_replaces_nothing_that_it_reads() {
    let place = place_with_folder();
    let absolute = place.path("dems/a.tif").display().to_string();
    let mut outputs = vec!["dems/a.tif", "dems/more/b.tif", "./dems/more/../a.tif", &absolute];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("dems/a.tif", place.path("link.tif")).unwrap();
        std::os::unix::fs::symlink("dems", place.path("folder")).unwrap();
        std::fs::hard_link(place.path("dems/more/b.tif"), place.path("hard.tif")).unwrap();
        outputs.extend(["link.tif", "folder/a.tif", "hard.tif"]);
    }
    for output in outputs {
        for inputs in [&["dems"][..], &["dems/a.tif", "dems/more/b.tif"]] {
            for more in [&["--resume"][..], &["--shard", "1/2"], &[]].into_iter().take(if full() { 3 } else { 1 }) {
                let line = place.refused(&[&["bake"], inputs, &["-o", output], more].concat());
                assert!(line.contains(output) && line.contains("is the input"), "{line}");
            }
        }
    }
    // A name in another case is the same file if the file system says so.
    if place.path("dems/A.TIF").exists() {
        assert!(place.refused(&["bake", "dems", "-o", "dems/A.TIF"]).contains("is the input"));
    }
    // The work folder of a bake is emptied and finally removed.
    place.geotiff("out.tif.parts/c.tif", 0);
    assert!(place.refused(&["bake", "out.tif.parts/c.tif", "-o", "out.tif"]).contains("is the input"));
}

#[test]
fn a_bake_into_the_folder_that_it_reads_is_refused() {
    let place = place_with_folder();
    for output in ["dems/all.tif", "dems/more/all.tif", "dems/more/../all.TIFF"] {
        let line = place.refused(&["bake", "dems", "-o", output]);
        assert!(line.contains(output) && line.contains("in the input folder dems"), "{line}");
    }
    // The output may be next to single input files, or in a folder that is not searched.
    std::fs::create_dir_all(place.path("dems/more/deep")).unwrap();
    let before = place.files();
    place.text(&["bake", "dems/a.tif", "dems/more/b.tif", "-o", "dems/all.tif"]);
    place.text(&["bake", "dems", "-o", "dems/more/deep/all.tif"]);
    assert!(
        place.refused(&["bake", "dems/more", "-o", "dems/more/deep/new.tif"]).contains("in the input folder dems/more")
    );
    let after = place.files();
    assert!(before.iter().all(|(path, bytes)| after[path] == *bytes), "{:?}", changed(&before, &after));
}

#[test]
fn a_picture_replaces_nothing_that_its_world_is_made_of() {
    let place = Place::empty();
    place.heightmap("heights.png");
    place.heightmap("001.png");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    place.file("hut.png", triangle);
    place.file("scene.toml", "[world]\ndem = \"heights.png\"\n[[meshes]]\nfile = \"hut.png\"\nat = [0, 0, \"+0\"]\n");
    place.file("frame.toml", "[world]\ndem = [\"heights.png\", \"001.png\"]\n");
    place.file("000.svg", PATH);
    let flight = ["--path", "000.svg", "--fps", "1"];
    let hatched = place.text(&["styles", "show", "stipple"]).replace("\"dots\"\nsize", "\"stack.toml\"\nsize");
    place.file("mine.toml", &hatched);
    place.file("stack.toml", "description = \"\"\nkind = \"stack\"\nimages = [\"light.png\"]\n");
    let mut square = hachure::file::png::PngWriter::create(&place.path("light.png"), 64, 64).unwrap();
    square
        .write_rows(
            &(0..64 * 64_u32).flat_map(|i| if i % 7 == 0 { [0, 0, 0, 255] } else { [255; 4] }).collect::<Vec<_>>(),
        )
        .unwrap();
    square.finish().unwrap();
    place.text(&["styles", "check", "mine.toml"]);

    let absolute = place.path("heights.png").display().to_string();
    let mut cases = vec![
        (vec!["heights.png", "-o", "heights.png"], "heights.png"),
        (vec!["heights.png", "-o", &absolute], &*absolute),
        (vec!["scene.toml", "-o", "./heights.png"], "./heights.png"),
        (vec!["scene.toml", "-o", "hut.png"], "hut.png"),
        (vec!["-o", "light.png", "--style", "mine.toml"], "light.png"),
        // The output would replace the first of two frames, then the second.
        ([&["-o", "%03d.svg", "--style", "strokes"], &flight[..]].concat(), "000.svg"),
        ([&["001.png", "-o", "%03d.png"], &flight[..]].concat(), "001.png"),
        ([&["frame.toml", "-o", "%03d.png"], &flight[..]].concat(), "001.png"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("heights.png", place.path("link.png")).unwrap();
        std::fs::hard_link(place.path("heights.png"), place.path("hard.exr")).unwrap();
        std::fs::hard_link(place.path("heights.png.toml"), place.path("hard.svg")).unwrap();
        cases.extend([
            (vec!["link.png", "-o", "heights.png"], "heights.png"),
            (vec!["scene.toml", "-o", "link.png"], "link.png"),
            (vec!["scene.toml", "-o", "hard.exr"], "hard.exr"),
            (vec!["scene.toml", "-o", "hard.svg", "--style", "strokes"], "hard.svg"),
        ]);
    }
    for (arguments, output) in cases {
        let arguments = [&["render"], &arguments[..], &["--size", "64x36"]].concat();
        let line = place.refused(&arguments);
        assert!(line.starts_with(&format!("{output}: is the input")), "{arguments:?}: {line}");
    }
}

#[test]
fn a_report_replaces_nothing_that_was_measured() {
    let place = Place::empty();
    place.heightmap("heights.png");
    for (name, arguments) in [
        ("out/frames.csv", &["heights.png", "--path", "out/frames.csv"][..]),
        ("out/report.json", &["heights.png", "--path", "out/report.json"]),
    ] {
        place.file(name, PATH);
        let line = place.refused(&[&["bench"], arguments, &["-o", "out"]].concat());
        assert!(line.contains(name) && line.contains("is the input"), "{line}");
    }
    // Nothing is created before all inputs are known.
    place.file("flight.csv", PATH);
    assert!(place.refused(&["bench", "nowhere.toml", "--path", "flight.csv", "-o", "new"]).contains("nowhere.toml"));
}

#[test]
fn a_tile_is_no_output_of_its_own_folder() {
    let place = Place::empty();
    // A height of 1000 m in Terrarium's colours.
    let tile = [131, 232, 0, 255].repeat(16 * 16);
    std::fs::create_dir_all(place.path("tiles/3/4")).unwrap();
    hachure::file::png::write_rgba8(&place.path("tiles/3/4/2.png"), 16, 16, &tile).unwrap();
    place.file("flight.csv", PATH);
    for arguments in [
        &["-o", "tiles/3/4/2.png"][..],
        &["-o", "tiles/3/4/3.png"],
        &["-o", "tiles/3/4/%d.png", "--path", "flight.csv"],
    ] {
        let line = place.refused(&[&["render", "tiles"], arguments].concat());
        assert!(line.contains("in the input folder tiles"), "{line}");
    }
}

/// Tests that a picture drawn into a folder of DEMs is not read as a DEM the next time.
#[test]
fn drawings_lie_in_a_folder_of_heights_unread() {
    if !has_gpu() {
        return;
    }
    let place = place_with_folder();
    let before = (place.files(), members(&place.path("dems")).unwrap());
    let render = ["render", "dems", "-o", "dems/view.png", "--style", "plain", "--size", "64x36"];
    place.text(&render);
    // The second run replaces its own picture.
    place.text(&render);
    assert_eq!(changed(&before.0, &place.files()), [place.path("dems/view.png")]);
    assert_eq!(members(&place.path("dems")).unwrap(), before.1);
    // A picture that could be read as heights, if hachure had not written it.
    let heights = [131, 232, 0, 255].repeat(64 * 64);
    hachure::file::png::write_rgba8(&place.path("dems/plain.png"), 64, 64, &heights).unwrap();
    assert_eq!(members(&place.path("dems")).unwrap(), before.1);
}
