//! The harness finds planted errors: parsers that panic, hang, use too much memory, and refuse with a wrong message.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::kinds::Kind;
use super::memory;
use super::seeds::Seed;
use super::watch::{Limits, Watch};

static IS_OVER: AtomicBool = AtomicBool::new(false);

fn panics(_: &Path) -> anyhow::Result<()> {
    panic!("planted");
}

fn hides_a_panic(_: &Path) -> anyhow::Result<()> {
    std::panic::catch_unwind(|| panic!("hidden")).map_err(|_| anyhow::anyhow!("toy.bin: is damaged"))
}

fn hangs(_: &Path) -> anyhow::Result<()> {
    while !IS_OVER.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn eats(_: &Path) -> anyhow::Result<()> {
    // Written to, because the system counts only used pages.
    let bytes = vec![1_u8; 200 << 20];
    anyhow::ensure!(std::hint::black_box(bytes).len() > 5, "toy.bin: is small");
    Ok(())
}

fn says(text: &str) -> anyhow::Result<()> {
    Err(anyhow::anyhow!("{text}"))
}

#[test]
fn planted_errors_are_found() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("toy.bin"), [1, 2, 3]).unwrap();
    let seed = Seed::of(folder.path(), "toy.bin");
    let mut watch = Watch::new(Limits { time: Duration::from_millis(700), memory_bytes: 100 << 20 });
    let mut found = |open: fn(&Path) -> anyhow::Result<()>| {
        let kind = Kind { name: "toy", open, seeds: |_| Vec::new(), arguments: None };
        watch.run(&kind, &seed).what.unwrap_or_default()
    };
    assert_eq!(found(|_| Ok(())), "");
    assert_eq!(found(|_| says("toy.bin: is damaged: it ends early")), "");
    assert!(found(panics).contains("planted"));
    assert!(found(hides_a_panic).contains("hidden"));
    assert!(found(hangs).contains("a hang"));
    // The harness goes on after a hang.
    assert!(found(|_| says("it is damaged")).contains("does not name the file"));
    assert!(found(|path| says(&format!("{}: {}", path.display(), "x".repeat(200)))).contains("longer than"));
    assert!(found(|_| says("toy.bin: has \u{1b}[31m in it")).contains("control characters"));
    match memory::is_measured() {
        true => assert!(found(eats).contains("MB of memory")),
        false => println!("skipped: the system does not report the memory of a process"),
    }
    IS_OVER.store(true, Ordering::Relaxed);
}
