//! Tests the program with its files, run as by scripts: inputs are never overwritten, texts are read from files only,
//! standard output may be closed or full, and a scene reads no files outside its folder without trust.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

#[path = "../../src/tests/common/faulty_server.rs"]
mod faulty_server;
mod guard;
mod place;
mod planted;
mod reach;
mod standard_output;
mod texts;
