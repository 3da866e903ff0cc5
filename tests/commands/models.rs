//! The program's output about models and their materials.

use super::Place;

const MODEL: &str = "mtllib tree.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl bark\nf 1 3 2\nf 1 2 4\nusemtl leaf\nf 1 4 3\n\
    usemtl root\nf 2 3 4\n";

fn scene(place: &Place) {
    let mesh = "[[meshes]]\nfile = \"tree.obj\"\nat = [0, 0, \"+0\"]\n";
    place.file("a.toml", &format!("[world]\nprocedural = {{ seed = 1 }}\n{mesh}{mesh}"));
    place.file("tree.obj", MODEL);
}

#[test]
fn materials_are_listed_and_their_faults_reported_once() {
    let place = Place::empty();
    scene(&place);
    place.file("tree.mtl", "newmtl bark\nKd 1 0 0\nnewmtl leaf\nKd 0 1 0\nmap_Kd leaf.png\n");
    let output = place.hachure(&["info", "a.toml"]);
    let (printed, warned) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success() && printed.matches(" m, 3 materials, at ").count() == 2, "{printed}");
    for warning in [
        "its texture \"leaf.png\" is not in its folder",
        "these materials are not in its libraries and are drawn plain: \"root\"",
    ] {
        assert_eq!(warned.matches(warning).count(), 1, "{warned}");
    }
    assert_eq!(warned.lines().count(), 2, "{warned}");
    assert_eq!(place.json(&["info", "a.toml", "--json"])["meshes"][0]["materials"], 3);
    // Planted error: a model without materials, of which nothing may be printed.
    place.file("tree.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let output = place.hachure(&["info", "a.toml"]);
    assert!(output.stderr.is_empty() && !String::from_utf8(output.stdout).unwrap().contains("material"));
}

#[test]
fn no_picture_replaces_a_texture() {
    let place = Place::empty();
    scene(&place);
    place.file("tree.mtl", "newmtl bark\nKd 1 0 0\nmap_Kd bark.png\n");
    place.file("bark.png", "a texture");
    let error = place.error(&["render", "a.toml", "-o", "bark.png"]);
    assert!(error.contains("bark.png: is the input"), "{error}");
    assert_eq!(std::fs::read(place.path("bark.png")).unwrap(), b"a texture");
}

#[test]
fn trees_of_a_forest_are_listed_and_read() {
    let place = Place::empty();
    let scene = "[world]\nprocedural = { seed = 1 }\n[[forest.species]]\nform = \"birch\"\n[[forest.species]]\n\
                 file = \"tree.obj\"\nheight_m = 21.5\nshare = 3\n";
    place.file("a.toml", scene);
    place.file("tree.obj", MODEL);
    let printed = String::from_utf8(place.hachure(&["info", "a.toml"]).stdout).unwrap();
    assert!(printed.contains("species   tree.obj: 4 triangles, 21.5 m tall, share 3\n"), "{printed}");
    assert!(printed.contains("species   birch, 18 m tall, share 1\n"), "{printed}");
    assert_eq!(printed.matches("species").count(), 2, "{printed}");
    // The default species, whose heights are products, and the default haze.
    place.file("default.toml", "[world]\nprocedural = { seed = 1 }\n[forest]\n");
    let default = String::from_utf8(place.hachure(&["info", "default.toml"]).stdout).unwrap();
    assert!(default.contains("species   broadleaf, 15.3 m tall, share 3\n"), "{default}");
    assert!(default.contains("haze      0.45 of the diagonal of the extent, at most 30 km\n"), "{default}");
    assert!(
        printed
            .contains("forest    at most 300 trees per hectare, on slopes up to 38°; level ground is water; seed 1\n"),
        "{printed}"
    );
    // Planted error: other rules, and wind, which must be printed.
    place.file(
        "b.toml",
        &scene.replace(
            "[[forest.species]]\nform",
            "[wind]\nspeed_m_s = 8\n[forest]\ntrees_per_ha = 20\n\
        tree_line_m = 900\nlevel_ground = \"land\"\n[[forest.species]]\nform",
        ),
    );
    let other = String::from_utf8(place.hachure(&["info", "b.toml"]).stdout).unwrap();
    assert!(
        other.contains(
            "forest    at most 20 trees per hectare below 900 m, on slopes up to 38°; level ground is land; seed 1\n"
        ),
        "{other}"
    );
    assert!(other.contains("wind      8 m/s from 270°\n") && !printed.contains("wind"), "{other}");
    let models = &place.json(&["info", "a.toml", "--json"])["tree_models"];
    assert!(models[0]["triangles"] == 4 && models[0]["up"] == "y" && models[1].is_null(), "{models}");
    // An output may not replace a file that the scene reads.
    place.file("tree.mtl", "newmtl bark\nKd 1 0 0\nmap_Kd bark.png\n");
    place.file("bark.png", "a texture");
    let error = place.error(&["render", "a.toml", "-o", "bark.png"]);
    assert!(error.contains("bark.png: is the input"), "{error}");
    // Planted error: a missing model.
    std::fs::remove_file(place.path("tree.obj")).unwrap();
    let error = String::from_utf8(place.hachure(&["info", "a.toml"]).stderr).unwrap();
    assert!(error.contains("tree.obj does not exist") && error.lines().count() == 1, "{error}");
}
