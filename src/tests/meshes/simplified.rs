//! Tests that simplified meshes look like the original ones.

use std::path::Path;

use hachure::mesh::build::Soup;
use hachure::mesh::paint::Paint;
use hachure::mesh::silhouette::{overlap, views};
use hachure::mesh::simplify::simplify;
use hachure::mesh::{Material, Mesh, obj};

use crate::tests::meshes::shapes;

/// Returns the mean overlap of silhouettes from 20 directions that the simplifier does not use itself.
fn likeness(mesh: &Mesh, other: &Mesh) -> f64 {
    overlap(mesh, other, views(20, 1.0))
}

/// Returns a mesh scaled about its middle, with only some of its triangles.
fn changed(mesh: &Mesh, scale: f64, is_left: impl Fn(usize) -> bool) -> Mesh {
    let left = mesh.triangles.iter().enumerate().filter(|(i, _)| is_left(*i)).map(|(_, triangle)| triangle.corners);
    let places_m = mesh.vertices_m.iter().map(|at_m| glam::Vec3::from(*at_m).as_dvec3() * scale + mesh.middle_m);
    let soup = Soup { places_m: places_m.collect(), triangles: left.collect(), normals: Vec::new() };
    soup.into_mesh("changed".to_owned()).unwrap()
}

#[test]
fn a_sphere_stays_round() {
    let sphere = shapes::mesh(shapes::sphere(5));
    for (most, least) in
        [(sphere.triangles.len() / 4, 0.99), (sphere.triangles.len() / 16, 0.98), (80, 0.94), (20, 0.8)]
    {
        let less = simplify(&sphere, most);
        let like = likeness(&sphere, &less);
        println!("{most}: {} triangles, {like:.4}", less.triangles.len());
        assert!(less.triangles.len() <= most && like > least, "{most}: {like}");
        assert!(less.is_solid, "{most}: {:?}", less.flaws);
    }
    // Planted: a sphere scaled by 0.9.
    let like = likeness(&sphere, &changed(&sphere, 0.9, |_| true));
    assert!(like < 0.85, "{like}");
}

#[test]
fn bounds_hold_for_any_mesh() {
    let sphere = shapes::mesh(shapes::sphere(2));
    assert_eq!(simplify(&sphere, 10_000).triangles, sphere.triangles);
    for most in [0, 1, 2, 3, 7, 50] {
        for soup in [shapes::cube(), shapes::sheet(), shapes::sphere(2)] {
            let mesh = shapes::mesh(soup);
            let less = simplify(&mesh, most);
            assert!((1..=most.max(1)).contains(&less.triangles.len()), "{most}: {}", less.triangles.len());
            assert!(less.triangles.iter().flat_map(|it| it.normals).all(|normal| normal.is_normalized()));
        }
    }
    // Loose triangles, none of which touches another.
    let text: String = (0..300)
        .map(|i| format!("v {i} 0 0\nv {i} 0.1 0\nv {i} 0 0.1\nf {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3))
        .collect();
    let specks = obj::parse("specks".to_owned(), text.as_bytes()).unwrap();
    let less = simplify(&specks, 30);
    assert!((10..=30).contains(&less.triangles.len()), "{}", less.triangles.len());
}

#[test]
fn materials_and_creases_stay() {
    // A sphere whose upper half is red.
    let soup = shapes::sphere(4);
    let is_up =
        |triangle: &[u32; 3]| triangle.iter().map(|&corner| soup.places_m[corner as usize].z).sum::<f64>() > 0.0;
    let of_triangles: Vec<u16> = soup.triangles.iter().map(|triangle| u16::from(is_up(triangle))).collect();
    let red = Material { name: "red".to_owned(), color: [1.0, 0.0, 0.0] };
    let paint = Paint { materials: vec![Material::plain(String::new()), red], of_triangles };
    let sphere = soup.clone().into_painted_mesh("sphere".to_owned(), paint).unwrap();
    let less = simplify(&sphere, 320);
    assert_eq!(less.materials, sphere.materials);
    let wrong = |mesh: &Mesh, turn: u16| {
        let height = |i: usize| (0..3).map(|k| mesh.corner_m(i, k).z + mesh.middle_m.z).sum::<f64>() / 3.0;
        let is_wrong =
            |i: &usize| height(*i).abs() > 0.1 && u16::from(height(*i) > 0.0) != mesh.triangles[*i].material ^ turn;
        (0..mesh.triangles.len()).filter(is_wrong).count()
    };
    assert_eq!(wrong(&less, 0), 0);
    // Planted: swapped materials.
    assert!(wrong(&less, 1) > 250);
    assert!(less.is_solid, "the border between the colours must stay closed: {:?}", less.flaws);

    // The edges of a finely tessellated cube stay sharp.
    let mut text = String::new();
    for (axis, side) in (0..3).flat_map(|axis| [-1.0, 1.0].map(|side| (axis, side))) {
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            for (a, b) in if side > 0.0 { corners } else { [corners[3], corners[2], corners[1], corners[0]] } {
                let mut at = [side; 3];
                at[(axis + 1) % 3] = f64::from(a) / 4.0 - 1.0;
                at[(axis + 2) % 3] = f64::from(b) / 4.0 - 1.0;
                text += &format!("v {} {} {}\n", at[0], at[1], at[2]);
            }
            text += "f -4 -3 -2 -1\n";
        }
    }
    let cube = obj::parse("cube".to_owned(), text.as_bytes()).unwrap();
    assert!(cube.is_solid && cube.triangles.len() == 768);
    let less = simplify(&cube, 12);
    assert_eq!((less.triangles.len(), less.is_solid), (12, true));
    assert!(likeness(&cube, &less) > 0.995);
    for (i, triangle) in less.triangles.iter().enumerate() {
        let [a, b, c] = [0, 1, 2].map(|k| less.corner_m(i, k));
        let face = (b - a).cross(c - a).normalize();
        assert!(triangle.normals.iter().all(|normal| normal.distance(face) < 1e-3), "{:?}", triangle.normals);
    }
}

#[test]
fn real_models_look_like_themselves() {
    let Some(index) = crate::tests::common::real_data("OBJ_INDEX.txt") else { return };
    let folder = index.parent().unwrap().join("obj");
    let mut found = Vec::new();
    super::reader::files(&folder, &mut found);
    found.sort();
    let mut sums = [0.0; 4];
    // A model of 52 triangles, two for each leaf, cannot be recognisable with 13.
    let holds = |triangles: usize, [quarter, sixteenth]: [f64; 2]| match triangles {
        500.. => quarter > 0.92 && sixteenth > 0.6,
        100.. => quarter > 0.82 && sixteenth > 0.5,
        _ => quarter > 0.4,
    };
    for path in &found {
        let mesh = obj::read(path).unwrap();
        let name = path.strip_prefix(&folder).unwrap_or(Path::new("")).display();
        let likes = [4, 16].map(|part| {
            let most = mesh.triangles.len() / part;
            let less = simplify(&mesh, most);
            assert!(less.triangles.len() <= most && less.materials == mesh.materials);
            // A material of many triangles must still exist at a quarter of them.
            let count =
                |mesh: &Mesh, of: usize| mesh.triangles.iter().filter(|it| usize::from(it.material) == of).count();
            let is_lost = |of: &usize| count(&mesh, *of) >= mesh.triangles.len() / 8 && count(&less, *of) == 0;
            let lost: Vec<usize> = (0..mesh.materials.len()).filter(is_lost).collect();
            assert!(part > 4 || mesh.triangles.len() < 100 || lost.is_empty(), "{name}: {lost:?}");
            likeness(&mesh, &less)
        });
        let halved = likeness(&mesh, &changed(&mesh, 1.0, |i| i < mesh.triangles.len() / 2));
        let small = likeness(&mesh, &changed(&mesh, 0.9, |_| true));
        let [quarter, sixteenth] = likes;
        println!(
            "{name}: {} triangles, a quarter {quarter:.3}, a sixteenth {sixteenth:.3}; planted 0.9 {small:.3}, half {halved:.3}",
            mesh.triangles.len()
        );
        assert!(holds(mesh.triangles.len(), likes), "{name}");
        // Planted: a model scaled by 0.9, and one without half of its triangles.
        assert!(mesh.triangles.len() < 500 || !holds(mesh.triangles.len(), [small, small]), "{name}: {small}");
        assert!(mesh.triangles.len() < 500 || !holds(mesh.triangles.len(), [halved, halved]), "{name}: {halved}");
        sums.iter_mut().zip([quarter, sixteenth, small, halved]).for_each(|(sum, like)| *sum += like);
    }
    let means = sums.map(|sum| sum / found.len() as f64);
    println!("means: {means:.3?}");
    let is_alike = |quarter: f64, sixteenth: f64| quarter > 0.89 && sixteenth > 0.7;
    let [quarter, sixteenth, small, halved] = means;
    assert!(is_alike(quarter, sixteenth) && !is_alike(small, small) && !is_alike(halved, halved));
}
