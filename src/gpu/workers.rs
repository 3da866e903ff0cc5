//! Threads for the slow work of a renderer, such as compiling pipelines and computing textures. Frames collect the
//! results without waiting.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

const MAX_THREADS: usize = 4;

type Job<T> = Box<dyn FnOnce() -> T + Send>;

/// A pool of threads with a queue of jobs. Dropping it waits for the jobs that have begun, and drops the others.
pub(crate) struct Workers<T> {
    jobs: Option<Sender<Job<T>>>,
    done: Receiver<Option<T>>,
    threads: Vec<JoinHandle<()>>,
    is_over: Arc<AtomicBool>,
    /// Number of queued jobs whose results have not been taken.
    open: usize,
}

impl<T: Send + 'static> Default for Workers<T> {
    /// Starts half as many threads as the CPU has cores, at least one and at most four.
    fn default() -> Self {
        let (jobs, waiting) = channel::<Job<T>>();
        let (sender, done) = channel();
        let (waiting, is_over) = (Arc::new(Mutex::new(waiting)), Arc::new(AtomicBool::new(false)));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let start = |_| {
            let (waiting, sender, is_over) = (Arc::clone(&waiting), sender.clone(), Arc::clone(&is_over));
            std::thread::Builder::new().name("frame worker".to_owned()).spawn(move || work(&waiting, &sender, &is_over))
        };
        // If the system starts no thread at all, jobs stay in the queue; such a system has greater problems.
        let threads = (0..(cores / 2).clamp(1, MAX_THREADS)).filter_map(|number| start(number).ok()).collect();
        Self { jobs: Some(jobs), done, threads, is_over, open: 0 }
    }
}

impl<T: Send + 'static> Workers<T> {
    /// Queues a job, which runs on one of the threads.
    pub(crate) fn start(&mut self, job: impl FnOnce() -> T + Send + 'static) {
        if let Some(jobs) = &self.jobs {
            self.open += usize::from(jobs.send(Box::new(job)).is_ok());
        }
    }

    /// Takes a result, if there is one; does not wait. A job that panicked has no result.
    pub(crate) fn take(&mut self) -> Option<T> {
        while let Ok(done) = self.done.try_recv() {
            self.open -= 1;
            if done.is_some() {
                return done;
            }
        }
        None
    }

    /// Returns how many jobs are queued, are running, or have a result that has not been taken.
    pub(crate) fn open(&self) -> usize {
        self.open
    }
}

impl<T> Drop for Workers<T> {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        self.jobs = None;
        for thread in self.threads.drain(..) {
            // A driver must not be compiling while the process ends. Joining does not fail: panics of jobs are caught.
            let _ = thread.join();
        }
    }
}

fn work<T>(waiting: &Mutex<Receiver<Job<T>>>, done: &Sender<Option<T>>, is_over: &AtomicBool) {
    // These threads have the priority of the frame thread. A job sometimes holds a lock of the device, and a frame that
    // waits for a low-priority thread would wait for all other threads too.
    loop {
        let Ok(Ok(job)) = waiting.lock().map(|waiting| waiting.recv()) else { return };
        if is_over.load(Ordering::Relaxed) {
            return;
        }
        // The parser may panic on a shader that is being edited; the program goes on.
        let result = catch_unwind(AssertUnwindSafe(job)).ok();
        if done.send(result).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::time::{Duration, Instant};

    use super::*;

    fn all(workers: &mut Workers<u32>) -> Vec<u32> {
        let begun = Instant::now();
        let mut all = Vec::new();
        while workers.open() > 0 {
            all.extend(workers.take());
            assert!(begun.elapsed() < Duration::from_secs(60), "{} are open", workers.open());
            std::thread::sleep(Duration::from_millis(1));
        }
        all.sort_unstable();
        all
    }

    #[test]
    fn all_tasks_run_even_if_one_panics() {
        let mut workers = Workers::default();
        for number in 0..20 {
            workers.start(move || if number == 7 { panic!("planted") } else { number });
        }
        assert_eq!(all(&mut workers), (0..20).filter(|number| *number != 7).collect::<Vec<_>>());
        workers.start(|| 99);
        assert_eq!(all(&mut workers), [99]);
    }

    #[test]
    fn dropping_the_workers_waits_only_for_running_tasks() {
        let (begun, has_begun) = channel();
        let (ended, has_ended) = channel();
        let mut workers = Workers::default();
        for _ in 0..1000 {
            let (begun, ended) = (begun.clone(), ended.clone());
            workers.start(move || {
                begun.send(()).unwrap();
                std::thread::sleep(Duration::from_millis(20));
                ended.send(()).unwrap();
            });
        }
        has_begun.recv().unwrap();
        drop(workers);
        let ended = has_ended.try_iter().count();
        assert_eq!(ended, 1 + has_begun.try_iter().count());
        assert!(ended < 100, "{ended}");
    }
}
