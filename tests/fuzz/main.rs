//! Mutated inputs of every kind that the program reads: none may cause a panic, take over 20 s or more than 1 GB, and
//! every refusal must be one line under 200 characters that names the file.
//!
//! A test runs some cases of each kind; `CONTRIBUTING.md` says how to run them for hours. A case depends only on the
//! seed, the kind and its number. A failure prints how to repeat the case, and its files are kept.
//!
//! - `HACHURE_FUZZ_CASES`: cases of each kind (24; with `HACHURE_TESTS=full` 100, and 10,000 of those in [`THOROUGH`])
//! - `HACHURE_FUZZ_FIRST`: number of the first case (0)
//! - `HACHURE_FUZZ_SEED`: another seed gives other cases (1)
//! - `HACHURE_FUZZ_TELL`: prints the result of each case
//! - `HACHURE_FUZZ_KIND`: only this kind, or several separated by commas
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

mod bounded;
#[allow(dead_code, reason = "tests/formats uses the rest")]
#[path = "../formats/dem.rs"]
mod dem;
mod dem_seeds;
mod kinds;
mod memory;
mod mutate;
mod planted;
mod program;
mod rule;
mod scenes;
mod seeds;
mod sparse;
mod watch;
#[path = "../../src/tests/pyramid/world.rs"]
mod world;
#[allow(dead_code, reason = "tests/formats uses the rest")]
#[path = "../formats/write.rs"]
mod write;

use std::time::Instant;

use kinds::KINDS;
use seeds::Seed;
use watch::{Limits, Watch};

/// The kinds of which a full run has 10,000 cases: several files, or text that a stranger may have written.
const THOROUGH: &[&str] = &[
    "imprint",
    "water",
    "water-mask",
    "scene",
    "forest-scene",
    "obj",
    "materials",
    "tile-folder",
    "gsi",
    "webp",
    "pmtiles",
    "netcdf",
    "archive",
    "exr-heights",
];

/// Reads a number from the environment.
fn number(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, expected a whole number")),
        Err(_) => default,
    }
}

#[test]
fn mutated_inputs_are_read_or_refused() {
    let is_full = std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full");
    let first = number("HACHURE_FUZZ_FIRST", 0);
    let run_seed = number("HACHURE_FUZZ_SEED", 1);
    let only = std::env::var("HACHURE_FUZZ_KIND").ok();
    let is_wanted = |name: &str| only.as_ref().is_none_or(|only| only.split(',').any(|wanted| wanted == name));
    assert!(KINDS.iter().any(|kind| is_wanted(kind.name)), "no kind is named {only:?}");

    let folder = tempfile::tempdir().unwrap();
    // A case that kills the whole process leaves its files there.
    println!("files are mutated in {}", folder.path().display());
    let mut watch = Watch::new(Limits::default());
    let mut failures = Vec::new();
    let mut all_refused = 0;
    println!("{:>14} {:>7} {:>7} {:>8} {:>7} {:>8}", "kind", "cases", "refused", "program", "peak MB", "seconds");
    for kind in KINDS.iter().filter(|kind| is_wanted(kind.name)) {
        let default = match is_full {
            true if THOROUGH.contains(&kind.name) => 10_000,
            true => 100,
            false => 24,
        };
        let cases = number("HACHURE_FUZZ_CASES", default);
        let start = Instant::now();
        let home = folder.path().join(kind.name);
        let seeds: Vec<Seed> = (kind.seeds)(&home);
        if seeds.is_empty() {
            continue;
        }
        for seed in &seeds {
            seed.restore();
            let case = watch.run(kind, seed);
            assert!(case.what.is_none(), "{}: the seed {:?} fails: {case:?}", kind.name, seed.entry);
            assert!(case.refusal.is_none(), "{}: the seed {:?} is refused: {case:?}", kind.name, seed.entry);
        }
        let (mut refused, mut spawned, mut peak_bytes) = (0, 0, 0);
        for number in first..first + cases {
            let mut random = mutate::Random::new(&format!("{run_seed} {} {number}", kind.name));
            let seed = &seeds[random.below(seeds.len())];
            let donor = &seeds[random.below(seeds.len())];
            seed.mutate(donor, &mut random);
            let mut case = watch.run(kind, seed);
            // A process for each case would take most of the time.
            if case.what.is_none() && program::is_due(number - first, cases) {
                spawned += u64::from(kind.arguments.is_some());
                case.what = program::fault(kind, seed);
            }
            refused += u64::from(case.refusal.is_some());
            if std::env::var_os("HACHURE_FUZZ_TELL").is_some() {
                println!("{number}: {}", case.refusal.as_deref().unwrap_or("read"));
            }
            peak_bytes = peak_bytes.max(case.peak_bytes.unwrap_or(0));
            if let Some(what) = case.what {
                let kept = seed.keep(kind.name, run_seed, number);
                let again = format!(
                    "HACHURE_FUZZ_SEED={run_seed} HACHURE_FUZZ_KIND={} HACHURE_FUZZ_FIRST={number} HACHURE_FUZZ_CASES=1",
                    kind.name
                );
                println!("FAILED {what}\n  kept in {}\n  again: {again}", kept.display());
                failures.push(format!("{}: {what}", kind.name));
            }
            seed.restore();
        }
        println!(
            "{:>14} {cases:>7} {refused:>7} {spawned:>8} {:>7} {:>8.1}",
            kind.name,
            peak_bytes / 1_000_000,
            start.elapsed().as_secs_f64()
        );
        // If no case is refused, the damage has no effect.
        assert!(cases < 100 || refused > 0, "{}: no case was refused", kind.name);
        all_refused += refused;
    }
    assert!(only.is_some() || all_refused > 0, "no case was refused");
    if !memory::is_measured() {
        println!("skipped: the system does not report the memory of a process");
    }
    assert!(failures.is_empty(), "{} cases failed:\n{}", failures.len(), failures.join("\n"));
}
