//! Labels on pictures: where they are. `picture::names` draws them.

pub(crate) mod placement;
