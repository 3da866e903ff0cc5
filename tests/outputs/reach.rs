//! Tests which files a scene may read: those in and below its folder, unless the user trusts the scene; and redirects
//! of a server.

use std::time::Duration;

use hachure::internals::RemoteFile;
use hachure::remote::{RemoteError, Settings};

use crate::faulty_server::Server;
use crate::place::Place;

const NOTES: &str = "notes that are none of a scene's business\n";

/// Returns a folder of scenes with a subfolder; files that scenes must not read are above it.
fn place() -> Place {
    let place = Place::empty();
    place.geotiff("scenes/sub/dem.tif", 0);
    place.file("scenes/sub/hut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.file("notes.txt", NOTES);
    place.file("scenesque/notes.txt", NOTES);
    place
}

fn scene(place: &Place, dem: &str, mesh: &str) {
    let text = format!("[world]\ndem = {dem}\n[[meshes]]\nfile = \"{mesh}\"\nat = [0, 0, \"+0\"]\n");
    place.file("scenes/scene.toml", text);
}

/// Runs all commands that open a scene, and returns their errors.
fn refusals(place: &Place, more: &[&str]) -> Vec<String> {
    place.file("flight.csv", crate::place::PATH);
    [
        &["info", "scenes/scene.toml"][..],
        &["render", "scenes/scene.toml", "-o", "x.png"],
        &["bench", "scenes/scene.toml", "--path", "flight.csv", "-o", "out"],
    ]
    .map(|arguments| place.refused(&[arguments, more].concat()))
    .to_vec()
}

#[test]
fn next_to_and_below_is_inside() {
    let place = place();
    let absolute = format!("{:?}", place.path("scenes/sub/dem.tif").display().to_string());
    for dem in
        ["\"sub/dem.tif\"", "\"./sub/../sub/dem.tif\"", "\"../scenes/sub/dem.tif\"", "[\"sub/dem.tif\"]", &absolute]
    {
        scene(&place, dem, "sub/hut.obj");
        assert!(place.text(&["info", "scenes/scene.toml"]).contains("dem.tif"), "{dem}");
    }
    // Run from within the folder, where the scene's name has no folder.
    scene(&place, "\"sub/dem.tif\"", "sub/hut.obj");
    let output = place.command(&["info", "scene.toml"]).current_dir(place.path("scenes")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    // A missing file is reported as missing.
    scene(&place, "\"sub/nowhere.tif\"", "sub/hut.obj");
    let line = place.refused(&["render", "scenes/scene.toml", "-o", "x.png"]);
    assert!(line.contains("nowhere.tif") && !line.contains("--trust-scene"), "{line}");
}

#[test]
fn what_leads_out_needs_trust() {
    let place = place();
    let absolute = place.path("notes.txt").display().to_string();
    let quoted = format!("{absolute:?}");
    let mut cases = vec![
        ("\"../notes.txt\"", "sub/hut.obj", "notes.txt"),
        ("\"sub/../../notes.txt\"", "sub/hut.obj", "notes.txt"),
        ("\"../scenesque/notes.txt\"", "sub/hut.obj", "notes.txt"),
        ("\"../nowhere.tif\"", "sub/hut.obj", "nowhere.tif"),
        (&quoted, "sub/hut.obj", "notes.txt"),
        ("[\"sub/dem.tif\", \"../notes.txt\"]", "sub/hut.obj", "notes.txt"),
        ("\"..\"", "sub/hut.obj", ".."),
        ("\"sub/dem.tif\"", "../notes.txt", "notes.txt"),
        ("\"sub/dem.tif\"", &absolute, "notes.txt"),
    ];
    #[cfg(unix)]
    {
        let link = |to: &str, name: &str| {
            std::fs::create_dir_all(place.path(name).parent().unwrap()).unwrap();
            std::os::unix::fs::symlink(to, place.path(name)).unwrap();
        };
        link("../notes.txt", "scenes/link.tif");
        link("..", "scenes/up");
        link("../../notes.txt", "scenes/folder/a.tif");
        place.geotiff("scenes/tiled/dem.tif", 0);
        link("../../notes.txt", "scenes/tiled/dem.tif.tiles");
        std::fs::create_dir_all(place.path("scenes/tiles/3/4")).unwrap();
        let tile = [131, 232, 0, 255].repeat(16 * 16);
        hachure::file::png::write_rgba8(&place.path("scenes/tiles/3/4/2.png"), 16, 16, &tile).unwrap();
        link("../../../../notes.txt", "scenes/tiles/3/4/3.png");
        cases.extend([
            ("\"link.tif\"", "sub/hut.obj", "link.tif"),
            ("\"up/notes.txt\"", "sub/hut.obj", "up/notes.txt"),
            ("\"folder\"", "sub/hut.obj", "folder/a.tif"),
            ("\"tiled/dem.tif\"", "sub/hut.obj", "dem.tif.tiles"),
            ("\"tiles\"", "sub/hut.obj", "3.png"),
            ("\"sub/dem.tif\"", "up/notes.txt", "up/notes.txt"),
        ]);
    }
    for (dem, mesh, named) in cases {
        scene(&place, dem, mesh);
        for line in refusals(&place, &[]) {
            let says = |what: &str| line.contains(what);
            assert!(line.starts_with("scenes/scene.toml: ") && says(named), "{dem}, {mesh}: {line}");
            assert!(says("is outside the scene's folder; --trust-scene"), "{dem}, {mesh}: {line}");
        }
        // With trust, the error is about the file itself.
        let output = place.run(&["info", "scenes/scene.toml", "--trust-scene"]);
        let error = String::from_utf8_lossy(&output.stderr);
        let is_its_own = ["cannot read the mesh", "not exist"].iter().any(|what| error.contains(what));
        assert!(output.status.success() || is_its_own, "{dem}, {mesh}: {error}");
    }
}

#[test]
fn urls_need_trust_and_keep_their_secrets() {
    let place = place();
    let server = Server::start(1);
    let url = server.url("nowhere.tif?key=secret").replace("http://", "http://me:pass@");
    scene(&place, &format!("{url:?}"), "sub/hut.obj");
    for line in refusals(&place, &[]) {
        assert!(line.contains("/nowhere.tif is a URL; --trust-scene"), "{line}");
        assert!(!line.contains("secret") && !line.contains("pass"), "{line}");
    }
    let asked = || server.counts().answers.load(std::sync::atomic::Ordering::Relaxed);
    assert_eq!(asked(), 0);
    let line = place.refused(&["render", "scenes/scene.toml", "--trust-scene", "-o", "x.png"]);
    assert!(line.contains("there is no such file") && asked() > 0, "{line}");
    // A URL on the command line needs no trust.
    let line = place.refused(&["render", &server.url("nowhere.tif"), "-o", "x.png"]);
    assert!(line.contains("there is no such file"), "{line}");
}

#[test]
fn a_server_sends_nobody_to_a_file() {
    let place = place();
    let server = Server::start(2);
    server.put("real.tif", b"heights".to_vec());
    let local = format!("file://{}", place.path("notes.txt").display());
    for (name, location) in [("a.tif", local.as_str()), ("b.tif", "ftp://127.0.0.1/x.tif"), ("c.tif", "data:,heights")]
    {
        server.redirect(name, location);
        let line = place.refused(&["render", &server.url(name), "-o", "x.png"]);
        assert!(line.contains(name) && line.contains("which is not followed"), "{line}");
        assert!(!line.contains("business"), "{line}");
    }
    // A redirect to another address on the web is followed.
    server.redirect("good.tif", &server.url("real.tif"));
    let settings = Settings { first_pause: Duration::from_millis(1), tries: 2, ..Settings::default() };
    let open = |name: &str| RemoteFile::open(&server.url(name), settings.clone());
    assert_eq!(open("good.tif").unwrap().read(0, 7, &|| false).unwrap(), b"heights");
    assert!(matches!(open("a.tif"), Err(RemoteError::Unusable { .. })));
}
