//! Labels on pictures: where they are. `picture::names` and `picture::contour_numbers` draw them.

pub(crate) mod numbers;
pub(crate) mod placement;
