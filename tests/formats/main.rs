//! Every format that hachure reads: files written here byte by byte, and by GDAL where it is installed.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

mod colours;
mod compare;
mod dem;
mod downloads;
mod encodings;
mod folders;
mod gdal;
mod hostile;
mod round_trip;
mod shapes;
mod side_files;
mod tiff;
mod windows;
mod write;
