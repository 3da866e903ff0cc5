//! A flight with Monado, an OpenXR runtime of others, where it is installed: `./check --full`.
//!
//! Monado draws for a simulated headset (`SIMULATED_ENABLE`) onto nothing (`XRT_COMPOSITOR_NULL`), so neither a headset
//! nor a display is needed. Its service and its library find each other through a socket in `XDG_RUNTIME_DIR`.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::Room;
use crate::common::full;

/// Where distributions install the manifest of Monado.
const MANIFESTS: [&str; 3] = [
    "/usr/share/openxr/1/openxr_monado.json",
    "/usr/local/share/openxr/1/openxr_monado.json",
    "/etc/xdg/openxr/1/openxr_monado.json",
];
/// Longest time for the service to begin, and for a flight to notice that it has ended.
const LONGEST: Duration = Duration::from_secs(60);

/// A process that ends with the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Process {
    /// Waits for the end; returns the exit status, or `None` if it takes too long.
    fn end(&mut self) -> Option<i32> {
        let begun = Instant::now();
        while begun.elapsed() < LONGEST {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        None
    }
}

/// Returns the service and the manifest of Monado, if they are installed.
fn monado() -> Option<(PathBuf, &'static str)> {
    let folders = std::env::var_os("PATH")?;
    let service = std::env::split_paths(&folders).map(|folder| folder.join("monado-service")).find(|it| it.exists())?;
    Some((service, MANIFESTS.into_iter().find(|manifest| Path::new(manifest).exists())?))
}

/// Starts the service, and waits for its socket.
fn start(room: &Room, service: &Path) -> Process {
    let child = Command::new(service)
        .env("XDG_RUNTIME_DIR", room.path(""))
        .env("XRT_COMPOSITOR_NULL", "1")
        .env("SIMULATED_ENABLE", "1")
        // Otherwise it ends when its standard input does.
        .env("XRT_NO_STDIN", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let process = Process(child);
    let begun = Instant::now();
    while !room.path("monado_comp_ipc").exists() {
        assert!(begun.elapsed() < LONGEST, "monado-service does not begin");
        std::thread::sleep(Duration::from_millis(50));
    }
    process
}

#[test]
fn monado_is_flown_with_and_its_end_is_one_line() {
    if !full() {
        return;
    }
    let Some((service, manifest)) = monado() else {
        println!("skipped: Monado is not installed (monado-service and openxr_monado.json)");
        return;
    };
    let Some(room) = Room::with_hill() else { return };
    let script = [("=XR_RUNTIME_JSON", manifest)];
    // The runtime is active, but its service is not.
    let run = room.fly(&script, &["--frames", "2"]);
    let line = run.stderr.lines().find(|line| line.starts_with("hachure: ")).unwrap_or_default();
    assert!(run.status == Some(1) && line.contains("does not answer"), "{}", run.stderr);

    let mut running = start(&room, &service);
    let run = room.fly(&script, &["--frames", "30", "--style", "plain"]);
    assert!(run.status == Some(0) && run.stdout.contains(" plain: 30 frames"), "{}{}", run.stdout, run.stderr);

    // Without a number of frames it flies until the service is gone.
    let mut command = room.command(Path::new(env!("CARGO_BIN_EXE_hachure")), &script);
    command.args(["fly", "world.tif", "--vr", "--style", "plain"]).stdout(Stdio::null());
    let log = room.path("flight.log");
    let mut flight = Process(command.stderr(std::fs::File::create(&log).unwrap()).spawn().unwrap());
    std::thread::sleep(Duration::from_secs(10));
    assert!(flight.0.try_wait().unwrap().is_none(), "{}", std::fs::read_to_string(&log).unwrap());
    running.0.kill().unwrap();
    let status = flight.end();
    let text = std::fs::read_to_string(&log).unwrap();
    // Monado's library may print lines of its own.
    let own = text.lines().filter(|line| line.starts_with("hachure: ")).count();
    assert!(status == Some(1) && own == 1, "{status:?}: {text}");
    assert!(running.end().is_none_or(|status| status != 0));
}
