//! Options of all commands that read heights: what is said of files that do not say it themselves.

use clap::Args;

use crate::source::{Encoding, OpenOptions};

/// What height files leave open.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct HeightArgs {
    /// How heights are packed into the colours of a terrain-RGB picture or tile folder: mapbox or terrarium
    #[arg(long, hide_possible_values = true)]
    pub encoding: Option<Encoding>,
}

impl HeightArgs {
    /// For the readers.
    #[must_use]
    pub fn options(&self) -> OpenOptions {
        OpenOptions { encoding: self.encoding, ..OpenOptions::default() }
    }
}
