//! Arguments only; the work is in `commands`.

fn main() {}
