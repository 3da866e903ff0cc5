//! A temporary folder of files in which the program runs, with detection of changes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use geotiff_writer::GeoTiffBuilder;
use hachure::file::atomic;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use ndarray::Array2;

/// No run takes longer on any machine; a run that waits for a pipe would.
const LONGEST: Duration = Duration::from_secs(100);

/// A camera path over any land.
pub(crate) const PATH: &str = "t,x,y,z,yaw,pitch,fov\n0,0,0,+50,0,-10,60\n1,10,10,+50,0,-10,60\n";

/// A temporary folder with its own cache.
pub(crate) struct Place(tempfile::TempDir);

/// Every file with its bytes, and every link with its target.
pub(crate) type Files = BTreeMap<PathBuf, Vec<u8>>;

impl Place {
    pub(crate) fn empty() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        fs::create_dir(place.path("cache")).unwrap();
        place
    }

    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and creates its folders.
    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        atomic::write(&path, bytes.as_ref()).unwrap();
        path
    }

    /// Writes a small GeoTIFF whose western edge is `column` samples further east.
    pub(crate) fn geotiff(&self, name: &str, column: u32) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let heights_m = Array2::from_shape_fn((40, 50), |(y, x)| 900.0 + (x as f32 * 0.3).sin() * 20.0 + y as f32);
        GeoTiffBuilder::new(50, 40)
            .epsg(32632)
            .pixel_scale(10.0, 10.0)
            .origin(500_000.0 + 10.0 * f64::from(column), 5_200_000.0)
            .write_2d(&path, heights_m.view())
            .unwrap();
    }

    /// Writes a heightmap of 16 bits with its sidecar file.
    pub(crate) fn heightmap(&self, name: &str) {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 48, 40);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let samples: Vec<u8> = (0..48 * 40_u16).flat_map(|i| (500 + i % 48 * 3 + i / 48).to_be_bytes()).collect();
        encoder.write_header().unwrap().write_image_data(&samples).unwrap();
        self.file(name, bytes);
        self.file(&format!("{name}.toml"), "spacing_m = 10\nheight_scale_m = 0.5\n");
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
        command.args(arguments).current_dir(self.root()).env("HACHURE_CACHE", self.path("cache"));
        // Without this folder, Mesa prints a warning.
        command.env("XDG_RUNTIME_DIR", self.root()).env_remove("RUST_LOG").stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the program and returns its output; the run must end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        finished(self.command(arguments).spawn().unwrap(), arguments)
    }

    pub(crate) fn text(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Returns the one line of error with which a run fails.
    pub(crate) fn error(&self, arguments: &[&str]) -> String {
        one_line(&self.run(arguments), arguments)
    }

    /// Like [`Place::error`], and checks that the run changed no file.
    pub(crate) fn refused(&self, arguments: &[&str]) -> String {
        let before = self.files();
        let line = self.error(arguments);
        assert_eq!(changed(&before, &self.files()), [] as [PathBuf; 0], "{arguments:?}: {line}");
        line
    }

    /// Returns all files except the cache.
    pub(crate) fn files(&self) -> Files {
        let mut files = Files::new();
        let mut folders = vec![self.root().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let entry = entry.unwrap();
                let (path, kind) = (entry.path(), entry.file_type().unwrap());
                if kind.is_symlink() {
                    let target = fs::read_link(&path).unwrap();
                    files.insert(path, target.into_os_string().into_encoded_bytes());
                } else if kind.is_file() {
                    files.insert(path.clone(), fs::read(&path).unwrap());
                } else if kind.is_dir() && path != self.path("cache") {
                    files.insert(path.clone(), Vec::new());
                    folders.push(path);
                }
            }
        }
        files
    }
}

/// Returns the paths that are in only one of the two, or differ.
pub(crate) fn changed(before: &Files, after: &Files) -> Vec<PathBuf> {
    let mut paths: Vec<&PathBuf> = before.keys().chain(after.keys()).collect();
    paths.sort();
    paths.dedup();
    paths.into_iter().filter(|path| before.get(*path) != after.get(*path)).cloned().collect()
}

/// Waits for a process, and kills it if it takes too long.
pub(crate) fn finished(mut child: Child, arguments: &[&str]) -> Output {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LONGEST {
            child.kill().unwrap();
            panic!("{arguments:?} did not end in time: {:?}", child.wait_with_output().unwrap());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

pub(crate) fn one_line(output: &Output, arguments: &[&str]) -> String {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {error}");
    let line = error.trim_end().strip_prefix("hachure: ").unwrap_or_else(|| panic!("{arguments:?}: {error}"));
    assert_eq!(line.lines().count(), 1, "{arguments:?}: {error}");
    line.to_owned()
}

/// Returns whether the long tier of the tests is wanted (`./check --full`).
pub(crate) fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

/// Returns whether there is a GPU to draw with; a software driver is enough.
pub(crate) fn has_gpu() -> bool {
    match Gpu::open(&AdapterWish::Best) {
        Ok(_) => true,
        Err(error) if std::env::var_os("HACHURE_REQUIRE_GPU").is_some_and(|wish| wish == "1") => panic!("{error}"),
        Err(error) => {
            println!("skipped: {error}");
            false
        }
    }
}
