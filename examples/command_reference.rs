//! Writes `docs/commands.md` from the definitions of the command line.
//!
//! `cargo run --release --example command_reference`

#[path = "shared/command_page.rs"]
mod command_page;

use std::path::Path;

use anyhow::Context;
use hachure::commands::program;
use hachure::file::atomic;

fn main() -> anyhow::Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md");
    let page = command_page::page(&program::definition());
    atomic::write(&path, page.as_bytes()).with_context(|| path.display().to_string())
}
