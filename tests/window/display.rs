//! A display in memory, and the program that runs on it.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use geotiff_writer::{GeoTiffBuilder, ModelType};
use hachure::file::png::{Picture, read_rgba8};
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat};
use x11rb::rust_connection::RustConnection;

/// A loaded machine without a GPU is slow.
const PATIENCE: Duration = Duration::from_secs(180);

/// A process that is killed when the test ends.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A display in memory.
pub(crate) struct Display {
    pub(crate) name: String,
    _server: Running,
}

impl Display {
    pub(crate) fn open() -> Option<Self> {
        Self::of_size("640x480x24")
    }

    /// Opens a display of a size, such as `640x480x24`.
    pub(crate) fn of_size(size: &str) -> Option<Self> {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", size, "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let output = server.stdout.take().unwrap();
        let server = Running(server);
        let mut number = String::new();
        // Xvfb prints the number of its display when it is ready.
        BufReader::new(output).read_line(&mut number).ok()?;
        (!number.trim().is_empty()).then(|| Self { name: format!(":{}", number.trim()), _server: server })
    }

    pub(crate) fn xdotool(&self, arguments: &[&str]) -> Option<String> {
        let output = Command::new("xdotool").args(arguments).env("DISPLAY", &self.name).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Returns what is shown in a part of the display, whose left top corner and size are given in pixels: red, green, blue
    /// and alpha of each pixel.
    pub(crate) fn pixels(&self, [left, top]: [i16; 2], [width, height]: [u16; 2]) -> Vec<u8> {
        let (connection, screen) = RustConnection::connect(Some(&self.name)).unwrap();
        let root = connection.setup().roots[screen].root;
        let image = connection.get_image(ImageFormat::Z_PIXMAP, root, left, top, width, height, !0).unwrap();
        let image = image.reply().unwrap();
        image.data.chunks_exact(4).flat_map(|pixel| [pixel[2], pixel[1], pixel[0], 255]).collect()
    }

    pub(crate) fn key(&self, arguments: &[&str]) {
        assert!(self.xdotool(arguments).is_some(), "xdotool {arguments:?}");
    }
}

/// Prints why a test cannot run; if everything is required, that is a failure.
fn skip(why: &str) {
    assert!(std::env::var_os("HACHURE_REQUIRE_GPU").is_none_or(|value| value != "1"), "cannot run: {why}");
    eprintln!("skipped: {why}");
}

fn is_installed(program: &str) -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|folder| folder.join(program).is_file())
}

pub(crate) fn until<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(start.elapsed() < PATIENCE, "{what} did not happen within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Writes a DEM of a cone with furrows.
pub(crate) fn write_dem(path: &Path) {
    let height_m = |(row, column): (usize, usize)| {
        let (x, y) = (column as f32 - 70.0, row as f32 - 60.0);
        900.0 - 12.0 * x.hypot(y) + 25.0 * (7.0 * y.atan2(x)).sin()
    };
    let heights_m = ndarray::Array2::from_shape_fn((120, 140), height_m);
    let builder = GeoTiffBuilder::new(140, 120).model_type(ModelType::Projected).epsg(32610);
    let builder = builder.pixel_scale(30.0, 30.0).origin(500_000.0, 5_000_000.0);
    builder.write_2d(path, heights_m.view()).unwrap();
}

pub(crate) fn pictures(folder: &Path) -> Vec<PathBuf> {
    let is_picture = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with("hachure-") && name.ends_with(".png")
    };
    folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).filter(is_picture).collect()
}

/// Presses F12 and reads the picture that this writes.
pub(crate) fn take_picture(display: &Display, folder: &Path) -> Picture {
    let before = pictures(folder);
    display.key(&["key", "F12"]);
    let path = until("F12", || pictures(folder).into_iter().find(|path| !before.contains(path)));
    read_rgba8(&path).unwrap()
}

/// Returns a picture after all tiles have arrived, when two successive pictures are the same.
pub(crate) fn settled(display: &Display, folder: &Path) -> Picture {
    let mut last = take_picture(display, folder);
    until("rest", || {
        std::thread::sleep(Duration::from_millis(300));
        let before = std::mem::replace(&mut last, take_picture(display, folder));
        (before == last).then_some(())
    });
    last
}

pub(crate) fn hachure(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hachure"));
    command.current_dir(folder).env("HACHURE_CACHE", folder.join("cache"));
    command.env("HACHURE_CONFIG", folder.join("config")).env_remove("WAYLAND_DISPLAY");
    command.env_remove("WAYLAND_SOCKET").env_remove("RUST_LOG");
    // Settings of the user must not change what is tested, and the sentences of the first start cover the picture.
    let settings = folder.join("config/settings.toml");
    if !settings.exists() {
        std::fs::create_dir_all(folder.join("config")).unwrap();
        std::fs::write(&settings, "[window]\nwelcomed = true\n").unwrap();
    }
    command.env("HACHURE_CONFIG", folder.join("config"));
    command
}

/// Returns whether everything that the window needs is installed, and prints what is missing.
pub(crate) fn can_run() -> bool {
    if let Some(missing) = ["Xvfb", "xdotool"].into_iter().find(|program| !is_installed(program)) {
        skip(&format!("{missing} is not installed"));
        return false;
    }
    Gpu::open(&AdapterWish::Best).inspect_err(|error| skip(&error.to_string())).is_ok()
}

/// Opens a window with a small world in `folder`. Standard error goes to the file `stderr` there. In the fast tier it
/// smooths no edges unless the arguments say so: a picture then takes one sample instead of 16, and a window at rest
/// draws nothing.
pub(crate) fn open(display: &Display, folder: &Path, environment: &[(&str, &Path)]) -> (Running, String) {
    open_with(display, folder, environment, &[])
}

/// Does the same with more arguments.
pub(crate) fn open_with(
    display: &Display,
    folder: &Path,
    environment: &[(&str, &Path)],
    arguments: &[&str],
) -> (Running, String) {
    write_dem(&folder.join("cone.tif"));
    let errors = folder.join("stderr");
    let mut command = hachure(folder);
    let is_smooth = is_full() || arguments.contains(&"--antialias");
    command
        .arg("cone.tif")
        .args(if arguments.contains(&"--size") { &[][..] } else { &["--size", "320x200"] })
        .args(if is_smooth { &[][..] } else { &["--antialias", "none"] })
        .args(arguments)
        .env("DISPLAY", &display.name)
        .env("XDG_RUNTIME_DIR", folder);
    command.envs(environment.iter().copied()).stderr(std::fs::File::create(&errors).unwrap());
    let mut program = Running(command.spawn().unwrap());
    let window = until("a window", || {
        assert!(program.0.try_wait().unwrap().is_none(), "{}", std::fs::read_to_string(&errors).unwrap());
        display.xdotool(&["search", "--onlyvisible", "--name", "hachure"]).filter(|id| !id.is_empty())
    });
    display.key(&["windowfocus", &window]);
    (program, window)
}

/// Returns whether the long tests run, too.
pub(crate) fn is_full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}
