//! Replaces `network.rs` in a build without the feature `network`: every URL is refused.

use std::ops::Range;

use super::transport::{Answer, NoAnswer};
use super::url::RemoteUrl;
use super::{Cancelled, RemoteError, Settings};

/// A server, which cannot exist in this build.
pub(super) enum Server {}

impl Server {
    pub(super) fn open(url: &RemoteUrl, _settings: &Settings) -> Result<Self, RemoteError> {
        let cause = "this build of hachure has no network access (it lacks the feature `network`)".to_owned();
        Err(RemoteError::Unusable { name: url.name.clone(), cause })
    }

    pub(super) fn get(
        &self,
        _range: Range<u64>,
        _url: &RemoteUrl,
        _cancelled: Cancelled<'_>,
    ) -> Result<Answer, NoAnswer> {
        match *self {}
    }
}
