//! The program beside its files, run as scripts run it: an input is never an output, texts are read from files only,
//! standard output may be closed or full, and a scene reaches no farther than it may.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic as the tests do")]

#[path = "../../src/tests/common/faulty_server.rs"]
mod faulty_server;
mod guard;
mod place;
mod reach;
mod standard_output;
mod texts;
