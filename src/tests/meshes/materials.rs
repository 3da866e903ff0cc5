//! Tests materials of models: how libraries are found, and which errors in them are reported.

use std::path::{Path, PathBuf};

use hachure::mesh::{Material, Mesh, obj};
use hachure::source::Silent;

/// Reads a mesh; returns it with the warnings about its materials.
fn read(path: &Path) -> Result<(Mesh, Vec<String>), String> {
    let mut reported = Vec::new();
    let mesh =
        obj::read_with(path, &Silent, &mut |warning| reported.push(warning)).map_err(|error| error.to_string())?;
    for warning in &reported {
        assert!(!warning.contains('\n') && warning.contains(&*path.parent().unwrap().to_string_lossy()), "{warning}");
    }
    Ok((mesh, reported))
}

const SQUARES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3 4\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// Reads a model whose last face, two triangles, has the material `bark`.
    fn model(&self, head: impl AsRef<[u8]>) -> (Mesh, Vec<String>) {
        let text = [head.as_ref(), SQUARES.as_bytes(), b"usemtl bark\nf 5 6 7 8\n"].concat();
        read(&self.file("model.obj", text)).unwrap()
    }
}

const BARK: &str = "newmtl bark\nKd 1 0 0\n";

fn is_bark(found: &(Mesh, Vec<String>), color: [f32; 3]) -> bool {
    let (mesh, reported) = found;
    let of: Vec<u16> = mesh.triangles.iter().map(|triangle| triangle.material).collect();
    assert_eq!(of, [0, 0, 1, 1]);
    assert_eq!(mesh.materials[0], Material::plain(String::new()));
    reported.is_empty() && mesh.materials[1..] == [Material { name: "bark".to_owned(), color }]
}

#[test]
fn libraries_are_found_however_they_are_named() {
    for (file, line) in [
        ("bark.mtl", "mtllib bark.mtl\n"),
        ("bark.mtl", "\u{feff}mtllib  ./bark.mtl \r\n"),
        ("Bark.MTL", "mtllib bark.mtl\n"),
        ("two words.mtl", "mtllib two words.mtl\n"),
        ("two words.mtl", "mtllib \"two words.mtl\"\n"),
        ("sub/bark.mtl", "mtllib sub\\bark.mtl\n"),
        ("bark.mtl", "mtllib C:\\models\\bark.mtl\n"),
        ("bark.mtl", "mtllib /home/somebody/bark.mtl\n"),
        ("baum rinde ä.mtl", "mtllib baum rinde ä.mtl\n"),
        ("bark.mtl", "mtllib \\\nbark.mtl\n"),
    ] {
        let folder = Folder::new();
        folder.file(file, BARK);
        assert!(is_bark(&folder.model(line), [1.0, 0.0, 0.0]), "{line}");
        // Planted: a library of another name is not found, and a warning says so.
        let (mesh, reported) = folder.model(line.replace("mtl", "mtx").replace("mtxlib", "mtllib"));
        assert!(mesh.materials[1].color == Material::PLAIN_COLOR && reported.len() == 2, "{reported:?}");
    }
    let folder = Folder::new();
    folder.file("rinde \u{e4}.mtl", BARK);
    assert!(is_bark(&folder.model(b"mtllib rinde \xe4.mtl\n"), [1.0, 0.0, 0.0]), "Latin-1");
    folder.file("a b.mtl", "newmtl leaf\nKd 0 1 0\n");
    folder.file("c.mtl", format!("newmtl\nKd 0\n{BARK}"));
    assert!(is_bark(&folder.model("mtllib a b.mtl c.mtl\n"), [1.0, 0.0, 0.0]), "two in a line");
    assert!(is_bark(&folder.model("mtllib a b.mtl\nmtllib c.mtl\n"), [1.0, 0.0, 0.0]), "two lines");
    folder.file("first.mtl", "newmtl bark\nKd 0 0 1\n");
    assert!(is_bark(&folder.model("mtllib first.mtl c.mtl\n"), [0.0, 0.0, 1.0]), "the first counts");
}

#[test]
fn a_model_reads_nothing_outside_of_its_folder() {
    let folder = Folder::new();
    folder.file("bark.mtl", BARK);
    let inner = "mtllib ../bark.mtl\n".to_owned() + SQUARES + "usemtl bark\nf 5 6 7 8\n";
    let path = folder.file("inner/model.obj", inner);
    let (mesh, reported) = read(&path).unwrap();
    assert!(mesh.materials[1].color == Material::PLAIN_COLOR && reported.len() == 2, "{reported:?}");
    assert!(obj::sidecar_files(&path).is_empty());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.0.path().join("bark.mtl"), folder.0.path().join("inner/bark.mtl")).unwrap();
        assert_eq!(read(&path).unwrap().1.len(), 2, "a link out of the folder must not be followed");
    }
    // Control: a library inside the folder is read.
    std::fs::remove_file(folder.0.path().join("inner/bark.mtl")).ok();
    let library = folder.file("inner/bark.mtl", BARK);
    assert!(is_bark(&read(&path).unwrap(), [1.0, 0.0, 0.0]));
    assert_eq!(obj::sidecar_files(&path), [library]);
}

#[test]
fn faulty_materials_give_a_warning_and_are_plain() {
    for (library, message, color) in [
        ("newmtl bark\nKd a b c\n", "line 2 is ignored: Kd needs", Material::PLAIN_COLOR),
        (
            "newmtl bark\nKd 1 0 0\nd 0.5\n",
            "these materials are transparent, but drawn opaque: \"bark\"",
            [1.0, 0.0, 0.0],
        ),
        ("newmtl bark\nKd 1 0 0\nTr 0.5\n", "transparent", [1.0, 0.0, 0.0]),
        ("newmtl bark\nKd 1 0 0\nmap_Kd -clamp on no such.png\n", "texture \"no such.png\" is not", [1.0, 0.0, 0.0]),
        ("newmtl bark\nKd 1 0 0\nmap_Kd broken.png\n", "broken.png", [1.0, 0.0, 0.0]),
        (
            "newmtl leaf\nKd 1 0 0\n",
            "these materials are not in its libraries and are drawn plain: \"bark\"",
            Material::PLAIN_COLOR,
        ),
        ("\0\u{1}PK", "not in its libraries", Material::PLAIN_COLOR),
    ] {
        let folder = Folder::new();
        folder.file("a.mtl", library);
        folder.file("broken.png", b"\x89PNG nothing");
        let (mesh, warnings) = folder.model("mtllib a.mtl\n");
        assert!(warnings.len() == 1 && warnings[0].contains(message), "{library}: {warnings:?}");
        assert_eq!((mesh.triangles.len(), mesh.materials[1].color), (4, color), "{library}");
    }
    let folder = Folder::new();
    folder.file("a.mtl", "newmtl bark\nKd 1 0 0\nd 1.0\nTr 1.0\n");
    assert!(is_bark(&folder.model("mtllib a.mtl\n"), [1.0, 0.0, 0.0]), "d counts, and Tr does not");
    // A folder with the library's name, and a library that is too long.
    std::fs::create_dir(folder.0.path().join("b.mtl")).unwrap();
    assert_eq!(folder.model("mtllib b.mtl\n").1.len(), 2);
    folder.file("c.mtl", vec![b'#'; (16 << 20) + 1]);
    assert!(folder.model("mtllib c.mtl\n").1[0].contains("at most 16 MiB"));
}

#[test]
fn a_texture_gives_its_mean_colour() {
    let folder = Folder::new();
    folder.file("a.mtl", "newmtl bark\nKd 0 0 1\nmap_Kd leaf.png\n");
    let png = |pixels: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(pixels).unwrap();
        folder.file("leaf.png", bytes);
    };
    // Transparent pixels do not count.
    png(&[255, 0, 255, 255, 9, 9, 9, 0]);
    assert!(is_bark(&folder.model("mtllib a.mtl\n"), [1.0, 0.0, 1.0]));
    png(&[255, 0, 0, 255, 0, 0, 0, 255]);
    assert!(is_bark(&folder.model("mtllib a.mtl\n"), [0.5, 0.0, 0.0]), "the mean must be of linear light");
    // A fully transparent texture is ignored.
    png(&[0; 8]);
    assert!(is_bark(&folder.model("mtllib a.mtl\n"), [0.0, 0.0, 1.0]));
    assert_eq!(obj::sidecar_files(&folder.0.path().join("model.obj")).len(), 2);
}

#[test]
fn materials_follow_their_faces() {
    // Polygons with lines and points between them, continued lines, and triangles that are dropped.
    let text = "usemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 2 2\nl 1 2\nf 1 2 3 4\np 1\nusemtl unused\n\
        usemtl b\nf 1 2 \\\n 5\nf 1 1 2\nusemtl a\nf 2 3\\\n 5\nf 3 2 5\nusemtl\nf 3 4 5\n";
    let mesh = obj::parse("a".to_owned(), text.as_bytes()).unwrap();
    let names: Vec<&str> = mesh.triangles.iter().map(|it| mesh.materials[it.material as usize].name.as_str()).collect();
    assert_eq!(names, ["a", "a", "b", "a", ""]);
    assert_eq!(mesh.materials.len(), 4, "plain, a, b, and the one without a name");
    // Materials do not affect the triangles.
    let bare: String =
        text.lines().filter(|line| !line.starts_with("usemtl")).map(|line| format!("{line}\n")).collect();
    let bare = obj::parse("a".to_owned(), bare.as_bytes()).unwrap();
    assert_eq!((&bare.vertices_m, bare.flaws), (&mesh.vertices_m, mesh.flaws));
    let plain = |mesh: &Mesh| mesh.triangles.iter().map(|it| (it.corners, it.across, it.normals)).collect::<Vec<_>>();
    assert_eq!(plain(&bare), plain(&mesh));
    // A face with two corners is skipped without shifting the materials of the others.
    let short = obj::parse("a".to_owned(), text.replace("f 1 1 2\n", "f 1 2\nf 1 1 2\n").as_bytes()).unwrap();
    assert_eq!(plain(&short), plain(&mesh));
    assert_eq!(short.materials.len(), 4);
}

type Outcome = Result<(usize, usize), &'static str>;

/// Odd files with their numbers of materials and warnings, or the end of the error message.
const ODD: &[(&str, Outcome)] = &[
    ("assimp/box_longline.obj", Ok((1, 1))),
    ("assimp/box_mat_with_spaces.obj", Ok((1, 2))),
    ("assimp/cube_usemtl.obj", Ok((3, 1))),
    ("assimp/empty.obj", Err("it has no faces")),
    ("assimp/empty_mat.obj", Ok((1, 0))),
    ("assimp/multiple_spaces.obj", Ok((0, 0))),
    ("assimp/number_formats.obj", Err("line 11: \"3.1+e2\" is not a number")),
    ("assimp/point_cloud.obj", Err("it has no faces")),
    ("assimp/testline.obj", Err("it has no faces")),
    ("assimp/testmixed.obj", Ok((1, 1))),
    ("assimp/testpoints.obj", Err("it has no faces")),
    ("tinyobjloader/colorspace-issue-184.obj", Ok((1, 1))),
    ("tinyobjloader/cube-vertex-w-component.obj", Ok((3, 0))),
    ("tinyobjloader/cube-vertexcol.obj", Ok((3, 0))),
    ("tinyobjloader/cube.obj", Ok((3, 0))),
    ("tinyobjloader/invalid-face-definition.obj", Err("line 15: a face needs 3 corners, but this one has 1")),
    ("tinyobjloader/invalid-relative-texture-index.obj", Err("line 2: the face uses vertex 1, but there are 0")),
    ("tinyobjloader/invalid-relative-vertex-index.obj", Err("line 1: the face uses vertex -4, but there are 0")),
    ("tinyobjloader/issue-140-zero-face-idx.obj", Err("line 16: the face uses vertex 0, but there are 4")),
    ("tinyobjloader/issue-161-inconsistent-f.obj", Ok((1, 1))),
    ("tinyobjloader/issue-162-smoothing-group.obj", Ok((2, 0))),
    ("tinyobjloader/issue-244-mtl-searchpaths.obj", Ok((2, 0))),
    ("tinyobjloader/issue-319-002.obj", Ok((0, 0))),
    ("tinyobjloader/issue-356-leading-spaces-newmtl.obj", Err("it has no faces")),
    ("tinyobjloader/issue-92.obj", Ok((1, 1))),
    ("tinyobjloader/leading-zero-in-exponent-notation-issue-210.obj", Ok((1, 0))),
    ("tinyobjloader/missing_material_file.obj", Ok((4, 1))),
    ("tinyobjloader/no_material.obj", Ok((0, 0))),
    ("tinyobjloader/norm-texopt.obj", Ok((1, 0))),
    ("tinyobjloader/pbr-mat-ext.obj", Ok((1, 0))),
    ("tinyobjloader/points-prim.obj", Err("it has no faces")),
    ("tinyobjloader/smoothing-normal.obj", Ok((1, 0))),
    ("tinyobjloader/test-nan.obj", Err("line 12: the vertex is not finite")),
    ("tinyobjloader/tr-and-d-issue-43.obj", Ok((2, 1))),
    ("tinyobjloader/usemtl-issue-104.obj", Ok((0, 1))),
    ("tinyobjloader/usemtl-issue-68.obj", Ok((2, 0))),
    ("tobj/triangle.obj", Ok((0, 0))),
];

#[test]
fn odd_files_have_their_materials_or_a_warning() {
    let Some(index) = crate::tests::common::real_data("OBJ_INDEX.txt") else { return };
    let folder = index.parent().unwrap().join("obj_odd");
    for (name, expected) in ODD {
        match (read(&folder.join(name)), expected) {
            (Ok((mesh, reported)), Ok((materials, warnings))) => {
                assert_eq!((mesh.materials.len() - 1, reported.len()), (*materials, *warnings), "{name}: {reported:?}");
            }
            (Err(error), Err(cause)) => assert!(error.ends_with(cause) && !error.contains('\n'), "{name}: {error}"),
            (found, _) => panic!("{name}: {:?}", found.map(|(mesh, _)| mesh.materials)),
        }
    }
    // Planted: a copy of a model without its library.
    let place = Folder::new();
    let cube = place.file("cube.obj", std::fs::read(folder.join("tinyobjloader/cube.obj")).unwrap());
    let (mesh, reported) = read(&cube).unwrap();
    assert_eq!((mesh.materials.len() - 1, reported.len()), (3, 2));
    assert!(mesh.materials.iter().all(|material| material.color == Material::PLAIN_COLOR));
}

#[test]
fn trees_have_the_colours_of_their_libraries() {
    let Some(index) = crate::tests::common::real_data("OBJ_INDEX.txt") else { return };
    let folder = index.parent().unwrap().join("obj");
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-3);
    let (oak, reported) = read(&folder.join("trees_kenney/tree_oak.obj")).unwrap();
    assert!(reported.is_empty() && oak.materials.len() == 3);
    // The colour is 41, 201, 171 of 255 in sRGB.
    assert!(near(oak.materials[1].color, [0.0222, 0.5841, 0.4072]), "{:?}", oak.materials);
    // Colours in Blender's files are linear.
    let (birch, _) = read(&folder.join("trees_quaternius/BirchTree_2.obj")).unwrap();
    let dark = birch.materials.iter().find(|material| material.name == "DarkGreen.001").unwrap();
    assert!(near(dark.color, [0.0425, 0.0727, 0.0296]), "{:?}", birch.materials);
    // The leaves are a PNG. The bark is a JPEG, which is not read.
    let (tree, reported) = read(&folder.join("trees_quaternius/Tree_3_textured.obj")).unwrap();
    assert!(reported.is_empty() && tree.materials.len() == 3);
    let [_, bark, leaves] = &tree.materials[..] else { panic!() };
    assert!(bark.color[0] == bark.color[2] && leaves.color[1] > leaves.color[0] && leaves.color[1] > leaves.color[2]);
}

#[test]
fn a_texture_is_read_once_by_whatever_names() {
    let folder = Folder::new();
    // A damaged texture gives a warning each time that it is read.
    let damaged = folder.file("leaf.png", b"\x89PNG nothing");
    std::fs::hard_link(&damaged, folder.0.path().join("link.png")).unwrap();
    let mut library = String::new();
    let mut text = "mtllib a.mtl ./a.mtl ././a.mtl\n".to_owned() + SQUARES;
    let names = (0..40).map(|i| format!("{}{}", "./".repeat(i % 20), if i < 20 { "leaf.png" } else { "LINK.png" }));
    for (number, name) in names.enumerate() {
        library += &format!("newmtl m{number}\nmap_Kd {name}\n");
        text += &format!("usemtl m{number}\nf 5 6 7 8\n");
    }
    folder.file("a.mtl", &library);
    let (mesh, warnings) = read(&folder.file("model.obj", &text)).unwrap();
    assert_eq!((mesh.materials.len(), warnings.len()), (41, 1), "{warnings:?}");
    // Planted: a copy is another file.
    folder.file("copy.png", b"\x89PNG nothing");
    folder.file("a.mtl", library.replace("././leaf.png", "copy.png"));
    assert_eq!(read(&folder.file("model.obj", &text)).unwrap().1.len(), 2);
}

#[test]
fn textures_that_inflate_to_much_more_than_their_files_are_left_out() {
    let folder = Folder::new();
    // 8192 × 16384 pixels in a few bytes: there is room for one of them, whose pixels do not fit in its file.
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8192, 16_384);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    let idat = [0x78, 0x9c, 3, 0, 0, 0, 0, 1];
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &idat).unwrap();
    for name in ["a.png", "b.png", "c.png"] {
        folder.file(name, &bytes);
    }
    folder.file("a.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nmap_Kd c.png\n");
    let text =
        "mtllib a.mtl\n".to_owned() + SQUARES + "usemtl a\nf 5 6 7 8\nusemtl b\nf 5 6 7 8\nusemtl c\nf 5 6 7 8\n";
    let (_, warnings) = read(&folder.file("model.obj", text)).unwrap();
    let too_many = warnings.iter().filter(|warning| warning.contains("too many pixels")).count();
    assert_eq!((warnings.len(), too_many), (3, 2), "{warnings:?}");
}
