//! Writes `docs/style-parameters.md` from the definitions of the parameters.
//!
//! `cargo run --release --example style_parameters`

use std::path::Path;

use anyhow::Context;
use hachure::file::atomic;
use hachure::internals::document;

fn main() -> anyhow::Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/style-parameters.md");
    atomic::write(&path, document().as_bytes()).with_context(|| path.display().to_string())
}
