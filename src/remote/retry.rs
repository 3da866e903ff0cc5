//! Retries requests after a pause that doubles, with random jitter, so that many readers do not retry at the same
//! moment.

use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};

use super::patience::Patience;
use super::transport::NoAnswer;
use super::{Cancelled, RemoteError, Settings};

/// Interval at which a pause checks for cancellation.
const LOOK: Duration = Duration::from_millis(20);

/// Repeats a request until it succeeds, cannot succeed, has been tried often enough, or the file's time limit is used
/// up. `failed` is called with the cause of each failed try.
pub(super) fn persistently<T>(
    name: &str,
    settings: &Settings,
    patience: &Patience,
    cancelled: Cancelled<'_>,
    mut request: impl FnMut() -> Result<T, NoAnswer>,
    failed: impl Fn(&str),
) -> Result<T, RemoteError> {
    let given_up = |tries: u32, cause: String| {
        patience.give_up(&cause);
        RemoteError::GivenUp { name: name.to_owned(), seconds: patience.limit().as_secs_f32(), tries, cause }
    };
    let _waiting = patience.begin().map_err(|cause| given_up(0, cause))?;
    let mut pause = settings.first_pause;
    let mut tries = 0;
    let mut before = None;
    loop {
        if cancelled() {
            return Err(RemoteError::Cancelled);
        }
        tries += 1;
        let (cause, asked) = match request() {
            Ok(answer) => return Ok(answer),
            // The request was not cancelled by the caller but by the time limit: the earlier cause says more.
            Err(NoAnswer::Never(RemoteError::Cancelled)) if !cancelled() => {
                (before.take().unwrap_or_else(|| "no complete answer".to_owned()), None)
            }
            Err(NoAnswer::Never(error)) => return Err(error),
            Err(NoAnswer::Again(cause)) => (cause, None),
            Err(NoAnswer::AfterPause(cause, asked)) => (cause, Some(asked)),
        };
        failed(&cause);
        if patience.left().is_zero() {
            return Err(given_up(tries, cause));
        }
        // There is no point in waiting for a server that requests a longer pause than the remaining time.
        if tries >= settings.tries || asked.is_some_and(|asked| asked > patience.left()) {
            return Err(RemoteError::Failed { name: name.to_owned(), tries, cause });
        }
        let end = Instant::now() + pause.mul_f64(1.0 - 0.5 * chance()).max(asked.unwrap_or_default());
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            if cancelled() {
                return Err(RemoteError::Cancelled);
            }
            if patience.left().is_zero() {
                return Err(given_up(tries, cause));
            }
            std::thread::sleep(left.min(LOOK));
        }
        pause = (pause * 2).min(settings.longest_pause);
        before = Some(cause);
    }
}

/// Returns a random number from 0 to 1: the standard library's hasher has a random key.
fn chance() -> f64 {
    (RandomState::new().hash_one(0) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remote::never;
    use std::cell::Cell;

    fn long() -> std::sync::Arc<Patience> {
        Patience::new(Duration::from_secs(600), Duration::from_secs(1))
    }

    #[test]
    fn gives_up_in_time() {
        let settings = Settings {
            first_pause: Duration::from_millis(2),
            longest_pause: Duration::from_millis(5),
            ..Settings::default()
        };
        let reported = Cell::new(0);
        let again = || Err::<(), _>(NoAnswer::Again("no".into()));
        let error = persistently("it", &settings, &long(), &never, again, |_| reported.set(reported.get() + 1));
        assert_eq!(error.unwrap_err().to_string(), "it: no answer after 6 tries: no");
        assert_eq!(reported.get(), 6);
        let mut left = 3;
        let later = || {
            left -= 1;
            if left == 0 { Ok(5) } else { Err(NoAnswer::Again(String::new())) }
        };
        assert_eq!(persistently("it", &settings, &long(), &never, later, |_| {}).unwrap(), 5);
        let patient = Settings { first_pause: Duration::from_secs(60), ..settings };
        let start = Instant::now();
        let soon = move || start.elapsed() > Duration::from_millis(50);
        let stopped = persistently("it", &patient, &long(), &soon, again, |_| {});
        assert!(matches!(stopped, Err(RemoteError::Cancelled)) && start.elapsed() < Duration::from_secs(5));
    }

    #[test]
    fn patience_ends_all_tries_and_the_servers_pause_is_kept() {
        let settings = Settings { tries: 1000, first_pause: Duration::from_millis(2), ..Settings::default() };
        let patience = Patience::new(Duration::from_millis(60), Duration::from_millis(10));
        let again = || Err::<(), _>(NoAnswer::Again("busy".into()));
        let ended = persistently("it", &settings, &patience, &never, again, |_| {}).unwrap_err();
        assert!(matches!(&ended, RemoteError::GivenUp { tries: 2.., .. }), "{ended}");
        // The next request fails with the same cause, and nothing is sent.
        let none = || -> Result<(), NoAnswer> { unreachable!("the file is left alone") };
        let ended = persistently("it", &settings, &patience, &never, none, |_| {}).unwrap_err();
        assert!(
            matches!(&ended, RemoteError::GivenUp { tries: 0, .. }) && ended.to_string().contains("busy"),
            "{ended}"
        );

        let mut asked = vec![Duration::from_secs(3600), Duration::from_millis(80)];
        let mut later = || asked.pop().map_or(Ok(()), |pause| Err(NoAnswer::AfterPause("busy".into(), pause)));
        let start = Instant::now();
        let failed = persistently("it", &settings, &long(), &never, &mut later, |_| {}).unwrap_err();
        assert!(start.elapsed() >= Duration::from_millis(80), "the pause that it asked for");
        assert!(matches!(failed, RemoteError::Failed { tries: 2, .. }), "an hour is too long: {failed}");
    }
}
