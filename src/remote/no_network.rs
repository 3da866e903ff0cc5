//! Replaces `network.rs` in a build without the feature `network`: every address is refused.

use std::ops::Range;

use super::address::Address;
use super::transport::{Answer, NoAnswer};
use super::{Cancelled, RemoteError, Settings};

/// A server, which cannot exist in this build.
pub enum Server {}

impl Server {
    pub fn open(address: &Address, _settings: &Settings) -> Result<Self, RemoteError> {
        let cause = "this build of hachure has no network access (it lacks the feature `network`)".to_owned();
        Err(RemoteError::Unusable { name: address.name.clone(), cause })
    }

    pub fn get(&self, _range: Range<u64>, _address: &Address, _cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        match *self {}
    }
}
