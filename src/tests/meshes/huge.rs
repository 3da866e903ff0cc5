//! Tests that reading a long file reports progress.

use std::fmt::Write as _;
use std::sync::Mutex;

use hachure::mesh::obj;
use hachure::source::Progress;

/// Returns the OBJ text of a sheet of `side` × `side` squares, with normals and materials.
fn sheet(side: u32) -> String {
    let mut text = String::from("o sheet\n");
    for (row, column) in (0..=side).flat_map(|row| (0..=side).map(move |column| (row, column))) {
        let z = (f64::from(row) * 0.37).sin() * (f64::from(column) * 0.21).cos();
        writeln!(text, "v {column}.125000 {row}.250000 {z:.6}\nvn 0.000000 {:.6} 1.000000", 0.1 * z).unwrap();
    }
    for row in 0..side {
        writeln!(text, "usemtl row{}", row % 3).unwrap();
        for column in 0..side {
            let a = row * (side + 1) + column + 1;
            let [b, c, d] = [a + 1, a + side + 2, a + side + 1];
            writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}\nf {a}//{a} {c}//{c} {d}//{d}").unwrap();
        }
    }
    text
}

#[derive(Default)]
struct Recorder(Mutex<Vec<(String, f32)>>);

impl Progress for Recorder {
    fn report(&self, what: &str, done: f32) {
        self.0.lock().unwrap().push((what.to_owned(), done));
    }
}

#[test]
fn a_long_file_reports_its_progress_and_is_the_same_in_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheet.obj");
    let text = sheet(420);
    assert!(text.len() > 16 << 20, "{}", text.len());
    std::fs::write(&path, &text).unwrap();
    let recorded = Recorder::default();
    let mesh = obj::read_with(&path, &recorded, &mut |_| ()).unwrap();
    // The file has more faces than are read in one piece, yet becomes one sheet with its materials.
    assert_eq!((mesh.vertices_m.len(), mesh.triangles.len()), (421 * 421, 2 * 420 * 420));
    assert_eq!((mesh.flaws.borders, mesh.flaws.crowded, mesh.flaws.dropped), (4 * 420, 0, 0));
    assert!((0..420).all(|row| mesh.triangles[2 * 420 * row + 7].material == (row % 3) as u16 + 1));
    let recorded = recorded.0.into_inner().unwrap();
    let of = |what: &str| recorded.iter().filter(|it| it.0.starts_with(what)).map(|it| it.1).collect::<Vec<_>>();
    for what in ["reading sheet.obj", "joining sheet.obj"] {
        let done = of(what);
        assert!(done.is_sorted() && done.len() >= 4 && done[0] < 0.1 && done[done.len() - 1] == 1.0, "{done:?}");
    }
    // A short file reports no progress.
    std::fs::write(&path, sheet(20)).unwrap();
    let short = Recorder::default();
    obj::read_with(&path, &short, &mut |_| ()).unwrap();
    assert!(short.0.into_inner().unwrap().is_empty());
    // An error at the end of a long file names its line.
    std::fs::write(&path, format!("{text}f 1//1 2//2 9999999//1\n")).unwrap();
    let error = obj::read(&path).unwrap_err().to_string();
    assert!(error.contains(&format!("line {}: ", text.lines().count() + 1)) && !error.contains('\n'), "{error}");
}

/// Measures time and memory of reading a long file.
#[test]
#[ignore = "measures the file that HACHURE_HUGE names"]
fn what_a_long_file_takes() {
    let path = std::env::var_os("HACHURE_HUGE").unwrap();
    let start = std::time::Instant::now();
    let mesh = obj::read(path.as_ref()).unwrap();
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default();
    println!("{} triangles, {:?}, {peak}", mesh.triangles.len(), start.elapsed());
    let start = std::time::Instant::now();
    let less = hachure::mesh::simplify::simplify(&mesh, mesh.triangles.len() / 16);
    println!("{} triangles, {:?}", less.triangles.len(), start.elapsed());
}
