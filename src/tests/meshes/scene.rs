//! Tests scene files with models.

use std::path::Path;

use glam::DVec3;
use hachure::scene::{Density, MeshPlace, MeshPlacement, MeshPositions, Scatter, Scene};
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
        positions: MeshPositions::At(MeshPlace { at_m: DVec3::new(120.0, -40.5, 0.5), height_above_ground: true }),
        yaw_deg: 0.0,
        scale: 1.0,
        z_up: false,
    };
    assert_eq!(found.meshes[0], hut);
    let statue = &found.meshes[1];
    assert!(statue.file == Path::new("/tmp/statue.obj") && statue.z_up);
    let at = MeshPlace { at_m: DVec3::new(1.0, 2.0, 300.0), height_above_ground: false };
    assert_eq!((&statue.positions, statue.yaw_deg, statue.scale), (&MeshPositions::At(at), 90.0, 0.01));
    assert!(scene("").unwrap().meshes.is_empty());
}

#[test]
fn a_scene_says_where_many_of_a_mesh_stand() {
    let found = scene(
        "[[meshes]]\nfile = \"hut.obj\"\ninstances = \"huts.csv\"\n\
         [[meshes]]\nfile = \"rock.obj\"\nscatter = { per_ha = 2.5, within = [-9, -8, 7, 6] }\n\
         [[meshes]]\nfile = \"rock.obj\"\nscatter = { count = 500, within = [0, 0, 900, 900], seed = 7, up_m = -0.2, \
         heights_m = [800, 2000], steepest_deg = 25, scale = [0.5, 2], turn_deg = [-20, 20] }\n",
    )
    .unwrap();
    assert_eq!(found.meshes[0].positions, MeshPositions::Listed("land/huts.csv".into()));
    let usual = Scatter {
        density: Density::PerHa(2.5),
        within_m: [-9.0, -8.0, 7.0, 6.0],
        heights_m: [-1e6, 1e6],
        steepest_deg: None,
        seed: 1,
        scale: [1.0, 1.0],
        turn_deg: [0.0, 360.0],
        up_m: 0.0,
    };
    assert_eq!(found.meshes[1].positions, MeshPositions::Scattered(usual));
    let given = Scatter {
        density: Density::Count(500),
        within_m: [0.0, 0.0, 900.0, 900.0],
        heights_m: [800.0, 2000.0],
        steepest_deg: Some(25.0),
        seed: 7,
        scale: [0.5, 2.0],
        turn_deg: [-20.0, 20.0],
        up_m: -0.2,
    };
    assert_eq!(found.meshes[2].positions, MeshPositions::Scattered(given));
}

#[test]
fn what_is_wrong_with_a_mesh_is_named() {
    let rule = "[[meshes]]\nfile = \"hut.obj\"\nscatter = { count = 5, within = [0, 0, 10, 10] }\n";
    let good = "[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2, \"+0\"]\n";
    for (meshes, named) in [
        (good.replace("hut.obj", ""), "meshes.file (mesh 1): "),
        (good.replace("\"+0\"", "\"0\""), "meshes.at (mesh 1): "),
        (good.replace("\"+0\"", "\"++1\""), "meshes.at (mesh 1): "),
        (good.replace("\"+0\"", "\"+nan\""), "meshes.at (mesh 1): "),
        (good.replace("[1, 2", "[1e9, 2"), "meshes.at (mesh 1): "),
        (good.replace("[1, 2, \"+0\"]", "[1, 2]"), "meshes"),
        (good.replace("[1, 2, \"+0\"]", "[1, 2, true]"), "meshes"),
        (format!("{good}yaw_deg = inf\n"), "meshes.yaw_deg (mesh 1): "),
        (format!("{good}scale = 0\n"), "meshes.scale (mesh 1): "),
        (format!("{good}scale = -1\n"), "meshes.scale (mesh 1): "),
        (format!("{good}up = \"x\"\n"), "meshes.up cannot be \"x\""),
        (format!("{good}colour = 3\n"), "unknown key \"meshes.colour\""),
        (format!("{good}{good}scale = nan\n"), "meshes.scale (mesh 2): "),
        ("[[meshes]]\nfile = \"hut.obj\"\n".to_owned(), "meshes.at (mesh 1): it needs at = "),
        (format!("{good}instances = \"a.csv\"\n"), "meshes.instances (mesh 1): it has both at and instances"),
        (format!("{rule}instances = \"a.csv\"\n"), "meshes.scatter (mesh 1): it has both instances and scatter"),
        ("[[meshes]]\nfile = \"hut.obj\"\ninstances = \"\"\n".to_owned(), "meshes.instances (mesh 1): "),
        (rule.replace("count = 5", "count = 65537"), "meshes.scatter.count (mesh 1): it must be between 1 and 65536"),
        (rule.replace("count = 5", "count = 0"), "meshes.scatter.count (mesh 1): "),
        (rule.replace("count = 5", "per_ha = nan"), "meshes.scatter.per_ha (mesh 1): "),
        (rule.replace("count = 5", "per_ha = 1, count = 5"), "meshes.scatter.per_ha (mesh 1): scatter needs either"),
        (rule.replace("count = 5, ", ""), "meshes.scatter.per_ha (mesh 1): scatter needs either"),
        (rule.replace("count = 5", "per_ha = 1000").replace("10, 10]", "1e5, 1e5]"), "but at most 4194304 are allowed"),
        (rule.replace("0, 0, 10, 10", "0, 10, 10, 0"), "meshes.scatter.within (mesh 1): "),
        (rule.replace(" }", ", scale = [2, 1] }"), "meshes.scatter.scale (mesh 1): "),
        (rule.replace(" }", ", steepest_deg = 91 }"), "meshes.scatter.steepest_deg (mesh 1): "),
        (rule.replace(" }", ", slope = 1 }"), "slope"),
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
    // The axis that points to the viewer in the file (z) points south.
    assert!((stance(0.0, false) * DVec3::Y).abs_diff_eq(DVec3::Z * 2.0, 1e-12));
    assert!((stance(0.0, false) * DVec3::Z).abs_diff_eq(-DVec3::Y * 2.0, 1e-12));
    // A quarter turn clockwise rotates it from south to west.
    assert!((stance(90.0, false) * DVec3::Z).abs_diff_eq(-DVec3::X * 2.0, 1e-12));
    assert!((stance(90.0, true) * DVec3::Y).abs_diff_eq(DVec3::X * 2.0, 1e-12));
    assert!((stance(17.0, false).determinant() - 8.0).abs() < 1e-12, "the transform must not mirror");
}

#[test]
fn a_scene_opens_with_its_meshes_or_says_what_is_wrong() {
    let Some(gpu) = crate::tests::common::gpu() else { return };
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
    assert_eq!((placed.meshes.len(), placed.standing.len()), (1, 2), "the file must be read once");
    let ground_m = world.ground_m(10.0, 20.0);
    assert!((placed.standing[1].middle_m.z - ground_m - 1.0).abs() < 1e-9 && ground_m > 100.0);

    std::fs::write(folder.path().join("broken.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    for (file, cause) in
        [("broken.obj", "line 4: the face uses vertex 9, but there are 3"), ("none.obj", "there is no such file")]
    {
        write(file);
        let error = open().map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(file) && error.contains(cause) && !error.contains('\n'), "{error}");
    }
}

const HUT: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 2 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n";

#[test]
fn a_list_is_the_same_as_entry_after_entry() {
    let Some(gpu) = crate::tests::common::gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let rows: String =
        (0..32).map(|row| format!("{}\n", vec![(100 + row * row / 9).to_string(); 32].join(" "))).collect();
    write("land.asc", &format!("ncols 32\nnrows 32\nxllcorner 0\nyllcorner 0\ncellsize 30\n{rows}"));
    write("hut.obj", HUT);
    let places: Vec<[f64; 5]> = (0..40)
        .map(|i| {
            let at = |j: i64| crate::tests::common::random(i, j);
            [400.0 * at(0) - 200.0, 400.0 * at(1) - 200.0, 3.0 * at(2), 360.0 * at(3), 1.0 + 9.0 * at(4)]
        })
        .collect();
    let row = |[x, y, z, yaw, scale]: &[f64; 5]| format!("{x},{y},+{z},{yaw},{scale}\n");
    let entry = |[x, y, z, yaw, scale]: &[f64; 5]| {
        format!("[[meshes]]\nfile = \"hut.obj\"\nat = [{x:?}, {y:?}, \"+{z}\"]\nyaw_deg = {yaw:?}\nscale = {scale:?}\n")
    };
    write("huts.csv", &format!("x,y,z,yaw,scale\n{}", places.iter().map(row).collect::<String>()));
    write("others.csv", &format!("x,y,z,yaw,scale\n{}", places[1..].iter().map(row).collect::<String>()));
    let listed = |list: &str| format!("[[meshes]]\nfile = \"hut.obj\"\ninstances = \"{list}\"\n");
    let drawn = |meshes: &str| {
        write("scene.toml", &format!("[world]\ndem = \"land.asc\"\n{meshes}"));
        let path = folder.path().join("scene.toml");
        let mut world = OpenWorld::open(&gpu, path.to_str(), TerrainOptions::default()).unwrap();
        let pose = world.pose(&"0,-300,+60,0,-12,60".parse().unwrap());
        let mut renderer = hachure::frame::Renderer::new(&gpu).unwrap();
        let style = hachure::style::Style::load("lsa").unwrap();
        let view = crate::tests::common::draw::still(pose, [320, 180]);
        crate::tests::common::draw::draw(
            &gpu,
            &mut world.surfaces,
            &mut renderer,
            &view,
            &style,
            &crate::tests::common::draw::NOON,
        );
        let read =
            |kind| hachure::gpu::readback::read(&gpu, renderer.target(kind).unwrap(), [0, 0], [320, 180]).unwrap();
        let pictures = [read(&hachure::surface::SURFACE_ID), read(&hachure::composite::PICTURE)];
        (world.surfaces.meshes().unwrap().standing.clone(), pictures)
    };
    let one_by_one = drawn(&places.iter().map(entry).collect::<String>());
    let by_list = drawn(&listed("huts.csv"));
    assert!(by_list == one_by_one && by_list.0.len() == 40);
    let of_meshes = by_list.1[0].chunks_exact(4).filter(|id| id[3] >> 6 == 2).count();
    assert!(of_meshes > 500, "{of_meshes} pixels");
    // Planted: a list that lacks one row.
    let other = drawn(&listed("others.csv"));
    assert!(other.0 != by_list.0 && other.1[0] != by_list.1[0]);
    // An error in a list names its row. Scattered models are on the ground.
    write("huts.csv", "x,y\n1,2\n3,four\n");
    write("scene.toml", &format!("[world]\ndem = \"land.asc\"\n{}", listed("huts.csv")));
    let path = folder.path().join("scene.toml");
    let open = || OpenWorld::open(&gpu, path.to_str(), TerrainOptions::default());
    let error = open().map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("huts.csv:3: y is \"four\": not a number") && !error.contains('\n'), "{error}");
    let rule = "[[meshes]]\nfile = \"hut.obj\"\nscatter = { count = 300, within = [-400, -400, 400, 400] }\n";
    write("scene.toml", &format!("[world]\ndem = \"land.asc\"\n{rule}"));
    let world = open().unwrap();
    let standing = &world.surfaces.meshes().unwrap().standing;
    // The hut's bounding box has its middle 1 m above the origin.
    let is_on_ground = |at_m: DVec3| (at_m.z - 1.0 - world.ground_m(at_m.x, at_m.y)).abs() < 1e-6;
    assert!(standing.len() == 300 && standing.iter().all(|standing| is_on_ground(standing.middle_m)));
}

#[test]
fn the_hut_of_the_project_is_solid() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("terrain/hut.toml");
    let scene = Scene::read(&path).unwrap();
    let mesh = hachure::mesh::obj::read(&scene.meshes[0].file).unwrap();
    assert!(mesh.is_solid && mesh.flaws == Default::default(), "{:?}", mesh.flaws);
}
