//! Tests reading OBJ files, intact and damaged.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use hachure::mesh::{Across, Flaws, Mesh, obj};

use crate::tests::meshes::shapes;

fn parse(text: &str) -> Result<Mesh, String> {
    obj::parse("test.obj".to_owned(), text.as_bytes())
}

const CUBE: &str = "\
# caf\u{e9}
mtllib nothing.mtl
usemtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
vt 0 0
o cube
f 4 3 2 1
f 5 6 7 8
f 1/1 2/1 6/1 5/1
g other
s 1
f -6 -5 -1 \\
  -2
f 1 5 8 4
f 2 3 7 6
l 1 2
p 3
";

#[test]
fn a_cube_is_solid_and_has_its_normals() {
    let mesh = parse(CUBE).unwrap();
    assert_eq!((mesh.vertices_m.len(), mesh.triangles.len(), mesh.flaws), (8, 12, Flaws::default()));
    assert!(mesh.is_solid && mesh.middle_m == DVec3::splat(0.5));
    assert!((mesh.radius_m - 0.75_f64.sqrt()).abs() < 1e-6);
    // The mean of 12 edges of 1 m and 6 diagonals.
    assert!((mesh.mean_edge_m - (12.0 + 6.0 * 2.0_f64.sqrt()) / 18.0).abs() < 1e-6);
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.corner_m(i, k));
        let face = (b - a).cross(c - a).normalize();
        assert!(face.dot(a + b + c) > 0.0, "faces must point outward");
        assert!(
            triangle.normals.iter().all(|normal| normal.distance(face) < 1e-12),
            "normals must be those of the faces"
        );
        for (k, across) in triangle.across.iter().enumerate() {
            let Across::Triangle { index, is_turned: false } = *across else { panic!("{across:?}") };
            let other = &mesh.triangles[index as usize];
            let edge = [triangle.corners[k], triangle.corners[(k + 1) % 3]];
            let back = (0..3).find(|&j| [other.corners[(j + 1) % 3], other.corners[j]] == edge).unwrap();
            assert_eq!(other.across[back], Across::Triangle { index: i as u32, is_turned: false });
        }
    }
    // Planted: one wrong corner opens the cube.
    let open = parse(&CUBE.replace("f 2 3 7 6", "f 2 3 7 5")).unwrap();
    assert!(!open.is_solid && open.flaws != Flaws::default());
}

#[test]
fn what_is_inside_out_or_turned_is_known() {
    let mut soup = shapes::cube();
    soup.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    let mesh = shapes::mesh(soup);
    assert!(mesh.is_solid);
    assert!((0..12).all(|i| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.corner_m(i, k));
        (b - a).cross(c - a).dot(a) > 0.0
    }));
    let mut soup = shapes::cube();
    soup.triangles[5].swap(0, 1);
    let mesh = shapes::mesh(soup);
    let turned = |mesh: &Mesh, i: usize| {
        mesh.triangles[i].across.iter().all(|across| matches!(across, Across::Triangle { is_turned: true, .. }))
    };
    assert!(!mesh.is_solid && turned(&mesh, 5) && !turned(&mesh, 0));
}

#[test]
fn borders_crowded_edges_and_empty_triangles_are_counted() {
    let sheet = shapes::mesh(shapes::sheet());
    assert_eq!(sheet.flaws, Flaws { borders: 48, ..Flaws::default() });
    // Three triangles that share an edge, like leaves of a book.
    let book = parse("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nf 1 2 3\nf 1 2 4\nf 2 1 5\n").unwrap();
    assert_eq!(book.flaws, Flaws { borders: 6, crowded: 1, dropped: 0 });
    let spine: Vec<Across> = book.triangles.iter().map(|triangle| triangle.across[0]).collect();
    assert_eq!(spine, [Across::Border, Across::Again, Across::Again]);
    // The same triangle twice, from both sides, and two without area, the last of which welding finds.
    let twice = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 3 2 1\nf 1 1 2\nf 1 2 4\n";
    let mesh = parse(twice).unwrap();
    assert_eq!((mesh.triangles.len(), mesh.flaws), (1, Flaws { dropped: 3, borders: 3, crowded: 0 }));
}

#[test]
fn normals_are_the_files_or_smooth() {
    let sphere = shapes::mesh(shapes::sphere(3));
    let worst = |mesh: &Mesh| {
        let corners = (0..mesh.triangles.len()).flat_map(|i| (0..3).map(move |k| (i, k)));
        corners.map(|(i, k)| mesh.triangles[i].normals[k].angle_between(mesh.corner_m(i, k))).fold(0.0, f64::max)
    };
    let off = worst(&sphere);
    assert!(off < 0.02, "{off}");
    // Planted: flat shading is off by half a triangle.
    let mut flat = sphere.clone();
    for i in 0..flat.triangles.len() {
        let [a, b, c] = [0, 1, 2].map(|k| flat.corner_m(i, k));
        flat.triangles[i].normals = [(b - a).cross(c - a).normalize(); 3];
    }
    assert!(worst(&flat) > 0.05);
    let given = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 3 4\nvn 0 0 0\nvn nan 0 1\nf 1//1 2//2 3//3\n").unwrap();
    let normals = given.triangles[0].normals;
    assert!(normals[0].distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-12);
    assert!(normals[1] == DVec3::Z && normals[2] == DVec3::Z, "invalid normals must be computed from the faces");
    // If only some corners of a file have normals, all are computed.
    let some = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 3 4\nf 1//1 2//1 3//1\nf 2 4 3\n").unwrap();
    assert!(some.triangles.iter().all(|triangle| triangle.normals == [DVec3::Z; 3]));
}

#[test]
fn far_coordinates_keep_their_digits() {
    let far = CUBE.replace("v 0 ", "v 4500000 ").replace("v 1 ", "v 4500001 ");
    let mesh = parse(&far).unwrap();
    assert!(mesh.middle_m == DVec3::new(4_500_000.5, 0.5, 0.5) && mesh.vertices_m.iter().all(|v| v[0].abs() == 0.5));
}

#[test]
fn hostile_files_are_errors_of_one_line() {
    let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let cases = [
        String::new(),
        "\0\0\0\0".to_owned(),
        three.to_owned(),
        "f 1 2 3\n".to_owned(),
        format!("{three}f 1 2 4\n"),
        format!("{three}f 0 1 2\n"),
        format!("{three}f 1 2 -4\n"),
        format!("{three}f 1 2 99999999999999999999\n"),
        format!("{three}f 1 2 9223372036854775807\n"),
        format!("{three}f 1 2 -9223372036854775808\n"),
        format!("{three}f 1 2\n"),
        format!("{three}f\n"),
        format!("{three}f a b c\n"),
        format!("{three}f 1 1 1\n"),
        "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 1e300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 1e400\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0 1 1e-300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "v \\\n\\\n\\".to_owned(),
    ];
    for text in cases {
        let error = parse(&text).map(|mesh| mesh.triangles.len()).unwrap_err();
        assert!(!error.contains('\n') && !error.is_empty(), "{text:?}: {error}");
    }
}

#[test]
fn damage_never_panics() {
    let bytes = CUBE.as_bytes();
    let mut errors = 0;
    for end in 0..bytes.len() {
        errors += usize::from(obj::parse(String::new(), &bytes[..end]).is_err());
    }
    for at in 0..bytes.len() {
        for flip in [0x01, 0x10, 0x80, 0xff] {
            let mut damaged = bytes.to_vec();
            damaged[at] ^= flip;
            if let Err(error) = obj::parse(String::new(), &damaged) {
                assert!(!error.contains('\n'));
                errors += 1;
            }
        }
    }
    assert!(errors > 100, "damage was detected only {errors} times");
}

#[test]
fn a_fan_and_a_polygon_of_many_corners_take_no_time() {
    let count = 200_000_u32;
    let mut text = String::from("v 0 0 1\n");
    for i in 0..count {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(count)).sin_cos();
        text += &format!("v {cos} {sin} 0\n");
    }
    let ring: Vec<String> = (2..count + 2).map(|i| i.to_string()).collect();
    let polygon = format!("{text}f {}\n", ring.join(" "));
    for i in 0..count {
        text += &format!("f 1 {} {}\n", i + 2, (i + 1) % count + 2);
    }
    let start = Instant::now();
    let fan = parse(&text).unwrap();
    assert_eq!((fan.triangles.len(), fan.flaws.borders), (count as usize, u64::from(count)));
    assert_eq!(parse(&polygon).unwrap().triangles.len(), count as usize - 2);
    let took_s = start.elapsed().as_secs_f64();
    assert!(took_s < 20.0, "{took_s} s");
}

#[test]
fn what_is_no_file_is_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_owned(), folder.path().join("none.obj"), PathBuf::from("/dev/zero")] {
        let error = obj::read(&path).map(|_| ()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("cannot read the mesh {}: ", path.display())) && !error.contains('\n'));
    }
}

/// Appends every OBJ file in a folder and below it.
pub fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "obj") {
            found.push(path);
        }
    }
}

#[test]
fn real_files_load_or_say_why_not() {
    let Some(index) = crate::tests::common::real_data("OBJ_INDEX.txt") else { return };
    let mut found = Vec::new();
    files(index.parent().unwrap(), &mut found);
    let (mut loaded, mut good) = (0, 0);
    for path in &found {
        match obj::read(path) {
            Ok(mesh) => {
                assert!(
                    mesh.radius_m.is_finite()
                        && mesh.triangles.iter().flat_map(|t| t.normals).all(|n| n.is_normalized())
                );
                loaded += 1;
                good += usize::from(mesh.is_solid);
            }
            Err(error) => {
                let error = error.to_string();
                println!("{error}");
                assert!(!error.contains('\n') && error.contains(&*path.to_string_lossy()));
                assert!(path.to_string_lossy().contains("obj_odd"), "{error}");
            }
        }
    }
    println!("{loaded} of {} load, {good} are solid", found.len());
    assert!(loaded > 20);
}
