//! Scene files with meshes.

use std::path::Path;

use glam::DVec3;
use hachure::scene::{MeshPlacement, Scene};
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::OpenWorld;

fn scene(meshes: &str) -> Result<Scene, String> {
    let text = format!("[world]\nprocedural = {{ seed = 1 }}\n{meshes}");
    Scene::parse(Path::new("land/alps.toml"), &text).map_err(|error| error.to_string())
}

#[test]
fn a_scene_says_where_meshes_stand() {
    let found = scene(
        "[[meshes]]\nfile = \"hut.obj\"\nat = [120, -40.5, \"+0.5\"]\n\
         [[meshes]]\nfile = \"/tmp/statue.obj\"\nat = [1, 2, 300]\nyaw_deg = 90\nscale = 0.01\nup = \"z\"\n",
    )
    .unwrap();
    let hut = MeshPlacement {
        file: "land/hut.obj".into(),
        at_m: DVec3::new(120.0, -40.5, 0.5),
        height_above_ground: true,
        yaw_deg: 0.0,
        scale: 1.0,
        z_up: false,
    };
    assert_eq!(found.meshes[0], hut);
    let statue = &found.meshes[1];
    assert!(statue.file == Path::new("/tmp/statue.obj") && statue.z_up && !statue.height_above_ground);
    assert_eq!((statue.at_m, statue.yaw_deg, statue.scale), (DVec3::new(1.0, 2.0, 300.0), 90.0, 0.01));
    assert!(scene("").unwrap().meshes.is_empty());
}

#[test]
fn what_is_wrong_with_a_mesh_is_named() {
    let good = "[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2, \"+0\"]\n";
    for (meshes, named) in [
        (good.replace("hut.obj", ""), "meshes.file: of mesh 1: "),
        (good.replace("\"+0\"", "\"0\""), "meshes.at: of mesh 1: "),
        (good.replace("\"+0\"", "\"++1\""), "meshes.at: of mesh 1: "),
        (good.replace("\"+0\"", "\"+nan\""), "meshes.at: of mesh 1: "),
        (good.replace("[1, 2", "[1e9, 2"), "meshes.at: of mesh 1: "),
        (good.replace("[1, 2, \"+0\"]", "[1, 2]"), "meshes"),
        (good.replace("[1, 2, \"+0\"]", "[1, 2, true]"), "meshes"),
        (format!("{good}yaw_deg = inf\n"), "meshes.yaw_deg: of mesh 1: "),
        (format!("{good}scale = 0\n"), "meshes.scale: of mesh 1: "),
        (format!("{good}scale = -1\n"), "meshes.scale: of mesh 1: "),
        (format!("{good}up = \"x\"\n"), "meshes.up cannot be \"x\""),
        (format!("{good}colour = 3\n"), "there is no key \"meshes.colour\""),
        (format!("{good}{good}scale = nan\n"), "meshes.scale: of mesh 2: "),
        ("[[meshes]]\nfile = \"hut.obj\"\n".to_owned(), "meshes"),
    ] {
        let error = scene(&meshes).unwrap_err();
        assert!(
            error.starts_with("land/alps.toml") && error.contains(named) && !error.contains('\n'),
            "{meshes}: {error}"
        );
    }
}

#[test]
fn the_axes_of_a_file_are_turned_up_and_round() {
    let stance = |yaw_deg, z_up| {
        hachure::mesh::placed::Stance { origin_m: DVec3::ZERO, yaw_deg, scale: 2.0, z_up }.world_from_mesh()
    };
    // What points to the viewer in the file (z) looks south.
    assert!((stance(0.0, false) * DVec3::Y).abs_diff_eq(DVec3::Z * 2.0, 1e-12));
    assert!((stance(0.0, false) * DVec3::Z).abs_diff_eq(-DVec3::Y * 2.0, 1e-12));
    // A quarter turn clockwise: from the south to the west.
    assert!((stance(90.0, false) * DVec3::Z).abs_diff_eq(-DVec3::X * 2.0, 1e-12));
    assert!((stance(90.0, true) * DVec3::Y).abs_diff_eq(DVec3::X * 2.0, 1e-12));
    assert!((stance(17.0, false).determinant() - 8.0).abs() < 1e-12, "nothing is mirrored");
}

#[test]
fn a_scene_opens_with_its_meshes_or_says_what_is_wrong() {
    let Some(gpu) = crate::common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let land = folder.path().join("land.asc");
    let rows: String = (0..8).map(|row| format!("{}\n", vec![(100 + 10 * row).to_string(); 8].join(" "))).collect();
    std::fs::write(&land, format!("ncols 8\nnrows 8\nxllcorner 0\nyllcorner 0\ncellsize 30\n{rows}")).unwrap();
    let path = folder.path().join("scene.toml");
    let write = |file: &str| {
        let meshes = format!("[[meshes]]\nfile = \"{file}\"\nat = [10, 20, \"+1\"]\n");
        std::fs::write(&path, format!("[world]\ndem = \"land.asc\"\n{meshes}{meshes}")).unwrap();
    };
    let open = || OpenWorld::open(&gpu, path.to_str(), TerrainOptions::default());
    write("tile.obj");
    std::fs::write(folder.path().join("tile.obj"), "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n").unwrap();
    let world = open().unwrap();
    let placed = world.surfaces.meshes().unwrap();
    assert_eq!((placed.meshes.len(), placed.standing.len()), (1, 2), "the file is read once");
    let ground_m = world.ground_m(10.0, 20.0);
    assert!((placed.standing[1].middle_m.z - ground_m - 1.0).abs() < 1e-9 && ground_m > 100.0);

    std::fs::write(folder.path().join("broken.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    for (file, cause) in
        [("broken.obj", "line 4: the face names vertex 9, and there are 3"), ("none.obj", "No such file")]
    {
        write(file);
        let error = open().map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(file) && error.contains(cause) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn the_hut_of_the_project_is_solid() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("terrain/hut.toml");
    let scene = Scene::read(&path).unwrap();
    let mesh = hachure::mesh::obj::read(&scene.meshes[0].file).unwrap();
    assert!(mesh.is_solid && mesh.flaws == Default::default(), "{:?}", mesh.flaws);
}
