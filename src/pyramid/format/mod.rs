//! The file formats of a pyramid: the cloud-optimised GeoTIFF of heights, and the sidecar with everything that a
//! GeoTIFF has no tags for.
//!
//! The modules are listed in order of dependency: each uses only those above it. `encode`, `geotags` and `cog` write
//! the GeoTIFF, `stored` reads its levels back; `record`, `fingerprint` and `sidecar` define the bytes of the sidecar,
//! and `pair` finds both files and replaces them together.
//!
//! Why: `docs/decisions/cog-pyramid.md`, `docs/decisions/compression.md`.

pub(super) mod bytes;
pub(super) mod encode;
pub(crate) mod geotags;
pub(super) mod cog;
pub(super) mod stored;
pub(super) mod record;
pub(super) mod fingerprint;
pub(super) mod sidecar;
pub(super) mod pair;

pub(crate) use pair::next_path;
pub use sidecar::sidecar_path;
pub(crate) use sidecar::{LevelSummary, is_sidecar};
