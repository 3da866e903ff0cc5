#![allow(clippy::print_stdout, reason = "a test says what it measured and what it left out")]

use std::path::{Path, PathBuf};

use super::*;
use crate::forest::species::Detail;
use crate::mesh::build::Soup;
use crate::mesh::obj;
use crate::mesh::paint::Paint;
use crate::mesh::silhouette::{overlap, views};

/// The OBJ files of a folder of the test data; none if the folder is missing.
fn files(folder: &str) -> Vec<PathBuf> {
    let default_folder = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let data = std::env::var_os("HACHURE_TEST_DATA").map_or_else(default_folder, PathBuf::from);
    let (mut found, mut folders) = (Vec::new(), vec![data.join(folder)]);
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(ending) if ending == "obj" => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    if found.is_empty() {
        println!("skipped: {} holds no models", data.join(folder).display());
    }
    found
}

fn read(path: &Path) -> Result<Mesh, String> {
    obj::read_with(path, &crate::source::Silent, &mut |_| ()).map_err(|error| error.to_string())
}

fn mesh_of(places_m: Vec<DVec3>) -> Mesh {
    let triangles = (0..places_m.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Soup { places_m, triangles, normals: Vec::new() }.into_mesh("tree".to_owned()).unwrap()
}

/// Returns corners as a mesh.
fn seen(corners: &[TreeCorner]) -> Mesh {
    mesh_of(corners.iter().map(|corner| corner.at).collect())
}

/// Returns a generated tree as if from a user's file: z up, at an arbitrary place and size.
fn grown(grown: Grown) -> Mesh {
    let place = |corner: &Corner| DVec3::new(300.0, -70.0, 12.0) + 7.0 * corner.at;
    mesh_of(grown.grow(Detail::Near).iter().map(place).collect())
}

fn text(obj: &str) -> Mesh {
    obj::parse("a.obj".to_owned(), obj.as_bytes()).unwrap()
}

/// Returns the first fault of a model, if it has one.
fn fault(model: &TreeModel) -> Option<String> {
    for (corners, most) in [(&model.near, NEAR_TRIANGLES), (&model.middle, MIDDLE_TRIANGLES)] {
        if corners.is_empty() || corners.len() > 3 * most {
            return Some(format!("{} triangles", corners.len() / 3));
        }
        let [low, high] = bounds(corners.iter().map(|corner| corner.at));
        if low.z.abs() > 1e-9 || (high.z - 1.0).abs() > 1e-9 {
            return Some(format!("{} to {}", low.z, high.z));
        }
    }
    for triangle in [&model.near, &model.middle, &model.canopy].into_iter().flat_map(|all| all.as_chunks::<3>().0) {
        let [a, b, c] = triangle.each_ref().map(|corner| corner.at);
        let face = (b - a).cross(c - a).normalize_or_zero();
        for corner in triangle {
            let is_unit = (corner.normal.length() - 1.0).abs() < 1e-9 && corner.normal.dot(face) > 0.0;
            let is_light = (LIGHTNESS[0] - 1e-9..=LIGHTNESS[1] + 1e-9).contains(&corner.lightness);
            let sways = (0.0..=1.0).contains(&corner.sway) && (corner.at.z > 0.0 || corner.sway == 0.0);
            if !(is_unit && is_light && sways && corner.at.is_finite()) {
                return Some(format!("{corner:?} on {face}"));
            }
        }
    }
    None
}

#[test]
fn every_model_becomes_a_tree_or_one_line() {
    let paths: Vec<PathBuf> = ["obj", "obj_odd"].into_iter().flat_map(files).collect();
    let (mut trees, mut lines) = (0, 0);
    for path in &paths {
        for z_up in [false, true] {
            match read(path).and_then(|mesh| TreeModel::new(&mesh, z_up)) {
                Ok(model) => {
                    assert_eq!(fault(&model), None, "{}", path.display());
                    trees += 1;
                }
                Err(cause) => {
                    assert!(cause.lines().count() == 1 && path.to_string_lossy().contains("obj_odd"), "{cause}");
                    lines += 1;
                }
            }
        }
    }
    println!("{trees} trees, {lines} lines");
    assert!(paths.is_empty() || (trees > 80 && lines > 20), "{trees} {lines}");
    for of in Grown::ALL {
        let model = TreeModel::new(&grown(of), true).unwrap();
        assert_eq!(fault(&model), None, "{of:?}");
        // Planted: one that is taller, and one with a reversed triangle.
        let taller = |corner: &TreeCorner| TreeCorner { at: 1.01 * corner.at, ..*corner };
        assert!(fault(&TreeModel { near: model.near.iter().map(taller).collect(), ..model.clone() }).is_some());
        let mut turned = model;
        turned.near.as_chunks_mut::<3>().0[7].swap(0, 1);
        assert!(fault(&turned).is_some());
    }
}

#[test]
fn outlines_stay() {
    // The smallest overlaps are 0.996, of a near bob, and 0.848, of a middle spruce.
    let (min_near, min_middle) = (0.98, 0.82);
    let named = |path: &PathBuf| (path.file_name().unwrap().to_string_lossy().into_owned(), read(path).unwrap(), false);
    let mut all: Vec<(String, Mesh, bool)> = files("obj").iter().map(named).collect();
    all.extend(Grown::ALL.map(|of| (format!("{of:?}"), grown(of), true)));
    for (name, mesh, z_up) in &all {
        let whole = seen(&Own::of(mesh, *z_up).unwrap().corners(mesh));
        let model = TreeModel::new(mesh, *z_up).unwrap();
        let like = |corners: &[TreeCorner]| overlap(&whole, &seen(corners), views(20, 1.0));
        let (near, middle) = (like(&model.near), like(&model.middle));
        println!("{name}: {} triangles, near {near:.3}, middle {middle:.3}", mesh.triangles.len());
        assert!(near >= min_near && middle >= min_middle, "{name}");
        // Planted: a smaller tree, and one that has been tipped over.
        let changed = |place: fn(DVec3) -> DVec3| -> f64 {
            like(&model.near.iter().map(|corner| TreeCorner { at: place(corner.at), ..*corner }).collect::<Vec<_>>())
        };
        assert!(changed(|at| 0.85 * at) < min_near && changed(|at| DVec3::new(at.z, at.x, at.y)) < min_near, "{name}");
    }
}

#[test]
fn a_tree_stands_on_its_foot_whatever_points_up() {
    // A trunk, and a crown that leans to one side.
    let tree = |file: fn([f64; 3]) -> [f64; 3]| {
        let places = [[5.0, 7.0, 2.0], [6.0, 7.0, 2.0], [5.5, 8.0, 2.0], [9.0, 7.5, 6.0], [5.5, 7.5, 5.0]];
        let vertices = places.map(file).map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        text(&format!("{vertices}f 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 2 5\nf 4 5 1\n"))
    };
    let upright = TreeModel::new(&tree(|at| at), true).unwrap();
    let [low, high] = bounds(upright.near.iter().filter(|corner| corner.at.z == 0.0).map(|corner| corner.at));
    assert!((low + high).length() < 1e-6 && (low.x + 0.125).abs() < 1e-6, "{low} {high}");
    // The same tree with y up and z to the south.
    let lying = TreeModel::new(&tree(|[x, y, z]| [x, z, -y]), false).unwrap();
    let distance = |a: &TreeModel, b: &TreeModel| -> f64 {
        a.near.iter().zip(&b.near).map(|(a, b)| a.at.distance(b.at)).fold(0.0, f64::max)
    };
    assert!(distance(&upright, &lying) < 1e-6);
    // Planted: the wrong axis up.
    let wrong = TreeModel::new(&tree(|at| at), false).unwrap();
    assert!(distance(&upright, &wrong) > 0.1);
}

#[test]
fn a_model_that_is_not_a_tree_is_rejected() {
    let message = |obj: &str, z_up| TreeModel::new(&text(obj), z_up).unwrap_err();
    let sheet = "v 0 0 0\nv 50 0 0\nv 50 0 50\nf 1 2 3\n";
    assert_eq!(message(sheet, false), "it has no height");
    assert!(TreeModel::new(&text(sheet), true).is_ok());
    let low = sheet.replace("v 50 0 50", "v 50 1 50");
    assert!(
        message(&low, false).starts_with("it is 50 times as wide as tall, too wide for a tree"),
        "{}",
        message(&low, false)
    );
}

#[test]
fn sheets_wind_as_their_normals_say() {
    // The same sheet twice, once with its normal against its winding.
    let sheet = |normal: &str| text(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn {normal}\nf 1//1 2//1 3//1\n"));
    let model = |normal| TreeModel::new(&sheet(normal), false).unwrap();
    let (front, back) = (model("0 0 1"), model("0 0 -1"));
    assert!(fault(&front).is_none() && fault(&back).is_none());
    assert!((front.near[0].normal + back.near[0].normal).length() < 1e-9);
    // Planted: both wound as in the file.
    let swapped = TreeModel { near: [0, 2, 1].map(|i| back.near[i]).to_vec(), ..back };
    assert!(fault(&swapped).is_some());
}

#[test]
fn canopies_are_those_of_trees_of_the_same_outline() {
    for (of, expected) in [
        (Grown::Conifer, Grown::Conifer),
        (Grown::Broadleaf, Grown::Broadleaf),
        (Grown::Birch, Grown::Broadleaf),
        (Grown::Snag, Grown::Snag),
    ] {
        assert_eq!(TreeModel::new(&grown(of), true).unwrap().clump, expected, "{of:?}");
    }
    // Planted: a spruce upside down has no spire.
    let place = |corner: &Corner| DVec3::new(corner.at.x, corner.at.y, 1.0 - corner.at.z);
    let turned = mesh_of(Grown::Conifer.grow(Detail::Near).iter().map(place).collect());
    assert_eq!(TreeModel::new(&turned, true).unwrap().clump, Grown::Broadleaf);
    for path in files("obj/trees_kenney").into_iter().chain(files("obj/trees_quaternius")) {
        let name = path.file_stem().unwrap().to_string_lossy().to_lowercase();
        let expected = match () {
            () if name.contains("pine") => Grown::Conifer,
            () if name.contains("dead") => Grown::Snag,
            () => Grown::Broadleaf,
        };
        assert_eq!(TreeModel::new(&read(&path).unwrap(), false).unwrap().clump, expected, "{name}");
    }
}

#[test]
fn lightness_follows_colours() {
    let of = |color: [f32; 3]| lightness_of(&Material { name: "a".to_owned(), color });
    // Greens of leaves in linear light: spruce, oak, grass, a child's tree.
    for green in [[0.021, 0.061, 0.021], [0.043, 0.117, 0.021], [0.07, 0.25, 0.04], [0.022, 0.584, 0.407]] {
        assert!((0.46..=0.76).contains(&of(green)), "{}", of(green));
    }
    assert!(of([0.0; 3]) == LIGHTNESS[0] && of([1.0; 3]) > 0.9);
    for plain in [Material::PLAIN_COLOR, [0.64; 3], [0.8; 3]] {
        assert_eq!(of(plain), PLAIN_LIGHTNESS);
    }
    // A tall dark trunk and a crown of two colours, three quarters of it light: the canopy gets the crown's mean
    // lightness.
    let paint = |name: &str, color| Material { name: name.to_owned(), color };
    let dark = [0.02, 0.01, 0.01];
    let materials = vec![paint("bark", dark), paint("leaf", [0.1, 0.5, 0.1]), paint("twig", [0.05, 0.1, 0.02])];
    let upright = |x: f64, from: f64, to: f64, wide: f64| {
        [DVec3::new(x, 0.0, from), DVec3::new(x + wide, 0.0, from), DVec3::new(x, 0.0, to)]
    };
    let places_m = [upright(0.0, 0.0, 0.3, 8.0), upright(0.0, 0.5, 1.0, 3.0), upright(0.0, 0.5, 1.0, -1.0)].concat();
    let soup = Soup { places_m, triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]], normals: Vec::new() };
    let expected = 0.75 * of(materials[1].color) + 0.25 * of(materials[2].color);
    let mesh = soup.into_painted_mesh("a".to_owned(), Paint { materials, of_triangles: vec![0, 1, 2] }).unwrap();
    let model = TreeModel::new(&mesh, true).unwrap();
    assert!(model.canopy.iter().all(|corner| (corner.lightness - expected).abs() < 1e-9));
    assert_eq!(model.near[0].lightness, of(dark));
    // Planted: the trunk counted, too.
    assert!((expected - of(dark)).abs() > 0.1);
}
