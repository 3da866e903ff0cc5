//! Retries requests with exponential backoff and jitter: the pause doubles after each failure, and is shortened by up
//! to half at random, so that readers do not all retry at the same moment.

use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};

use super::patience::Patience;
use super::transport::NoAnswer;
use super::{Cancelled, RemoteError, Settings};

/// Interval at which a pause checks for cancellation and for the end of the file's patience.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Repeats a request until it succeeds, cannot succeed, has been tried `settings.tries` times, or the file's patience
/// is used up. `failed` is called with the cause of each failed try.
///
/// # Errors
/// Returns the request's own error if no further try can succeed; [`RemoteError::Failed`] after the last try, or if the
/// server requests a pause that is longer than the remaining patience; [`RemoteError::GivenUp`] without patience; or
/// [`RemoteError::Cancelled`].
pub(super) fn with_retries<T>(
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
    let _waiting = patience.start_waiting().map_err(|cause| given_up(0, cause))?;
    let mut pause = settings.first_pause;
    let mut tries = 0;
    let mut previous_cause = None;
    loop {
        if cancelled() {
            return Err(RemoteError::Cancelled);
        }
        tries += 1;
        let (cause, retry_after) = match request() {
            Ok(answer) => return Ok(answer),
            // The request was ended by the patience, not by the caller: the earlier cause says more.
            Err(NoAnswer::Never(RemoteError::Cancelled)) if !cancelled() => {
                (previous_cause.take().unwrap_or_else(|| "no complete answer".to_owned()), None)
            }
            Err(NoAnswer::Never(error)) => return Err(error),
            Err(NoAnswer::Again(cause)) => (cause, None),
            Err(NoAnswer::AfterPause(cause, pause)) => {
                (format!("{cause} and requests a pause of {} s", pause.as_secs_f32()), Some(pause))
            }
        };
        failed(&cause);
        if patience.remaining().is_zero() {
            return Err(given_up(tries, cause));
        }
        // After a requested pause that is longer than the remaining patience, no try would be left.
        if tries >= settings.tries || retry_after.is_some_and(|pause| pause > patience.remaining()) {
            return Err(RemoteError::Failed { name: name.to_owned(), tries, cause });
        }
        let end = Instant::now() + pause.mul_f64(1.0 - 0.5 * random_fraction()).max(retry_after.unwrap_or_default());
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            if cancelled() {
                return Err(RemoteError::Cancelled);
            }
            if patience.remaining().is_zero() {
                return Err(given_up(tries, cause));
            }
            std::thread::sleep(left.min(POLL_INTERVAL));
        }
        pause = (pause * 2).min(settings.longest_pause);
        previous_cause = Some(cause);
    }
}

/// Returns a random number in [0, 1), by the random keys of the standard library's hashers.
fn random_fraction() -> f64 {
    (RandomState::new().hash_one(0) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remote::never;
    use std::cell::Cell;

    fn ample() -> std::sync::Arc<Patience> {
        Patience::new(Duration::from_secs(600), Duration::from_secs(1))
    }

    fn short_pauses() -> Settings {
        let (first_pause, longest_pause) = (Duration::from_millis(2), Duration::from_millis(5));
        Settings { first_pause, longest_pause, ..Settings::default() }
    }

    fn no_answer() -> Result<(), NoAnswer> {
        Err(NoAnswer::Again("no".into()))
    }

    #[test]
    fn gives_up_after_the_last_try() {
        let reported = Cell::new(0);
        let failed = |_: &str| reported.set(reported.get() + 1);
        let error = with_retries("it", &short_pauses(), &ample(), &never, no_answer, failed).unwrap_err();
        assert_eq!(error.to_string(), "it: no answer after 6 tries: no");
        assert_eq!(reported.get(), 6);
    }

    #[test]
    fn a_later_try_may_succeed() {
        let mut tries = 0;
        let third = || {
            tries += 1;
            if tries == 3 { Ok(5) } else { Err(NoAnswer::Again(String::new())) }
        };
        assert_eq!(with_retries("it", &short_pauses(), &ample(), &never, third, |_| {}).unwrap(), 5);
    }

    #[test]
    fn a_pause_can_be_cancelled() {
        let settings = Settings { first_pause: Duration::from_secs(60), ..Settings::default() };
        let start = Instant::now();
        let soon = move || start.elapsed() > Duration::from_millis(50);
        let stopped = with_retries("it", &settings, &ample(), &soon, no_answer, |_| {});
        assert!(matches!(stopped, Err(RemoteError::Cancelled)) && start.elapsed() < Duration::from_secs(5));
    }

    #[test]
    fn without_patience_all_requests_end_with_the_same_cause() {
        let settings = Settings { tries: 1000, first_pause: Duration::from_millis(2), ..Settings::default() };
        let patience = Patience::new(Duration::from_millis(60), Duration::from_millis(10));
        let busy = || Err::<(), _>(NoAnswer::Again("busy".into()));
        let ended = with_retries("it", &settings, &patience, &never, busy, |_| {}).unwrap_err();
        assert!(matches!(&ended, RemoteError::GivenUp { tries: 2.., .. }), "{ended}");
        // The next request fails with the same cause, and nothing is sent.
        let none = || -> Result<(), NoAnswer> { unreachable!("the file is left alone") };
        let ended = with_retries("it", &settings, &patience, &never, none, |_| {}).unwrap_err();
        assert!(
            matches!(&ended, RemoteError::GivenUp { tries: 0, .. }) && ended.to_string().contains("busy"),
            "{ended}"
        );
    }

    #[test]
    fn the_servers_pause_is_kept_and_named() {
        let mut pauses = vec![Duration::from_secs(3600), Duration::from_millis(80)];
        let request = || pauses.pop().map_or(Ok(()), |pause| Err(NoAnswer::AfterPause("busy".into(), pause)));
        let start = Instant::now();
        let failed = with_retries("it", &short_pauses(), &ample(), &never, request, |_| {}).unwrap_err();
        assert!(start.elapsed() >= Duration::from_millis(80), "the server's pause is kept");
        // The second pause is longer than the patience.
        assert_eq!(failed.to_string(), "it: no answer after 2 tries: busy and requests a pause of 3600 s");
    }
}
