//! Parallel work on the inputs of a batch, results in order.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::terminal::console::Console;
use crate::terminal::exit_code::Problem;

/// Does `work` with every item and returns the results in the order of the items, or the error of the first item (in
/// their order) that ended the batch.
///
/// At most `at_once` items are in work, and no more than there are threads to compute: with work stealing alone, a thread
/// that waits for a part of one item would start another, and each item in work holds a measured file in memory. After an error no new item
/// is started.
///
/// # Errors
/// The error of the first item that failed.
pub(crate) fn each<I: Sync, T: Send, E: Send>(
    items: &[I],
    at_once: usize,
    work: impl Fn(&I) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let results: Vec<Mutex<Option<Result<T, E>>>> = items.iter().map(|_| Mutex::new(None)).collect();
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let worker = || {
        while !stop.load(Ordering::Relaxed) {
            let n = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(n) else { return };
            let result = work(item);
            stop.fetch_or(result.is_err(), Ordering::Relaxed);
            *results[n].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        }
    };
    let threads = rayon::current_num_threads().min(items.len()).min(at_once);
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(worker);
        }
        worker();
    });
    // Items that were never started lie behind the one that failed.
    results.into_iter().map_while(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// As [`each`], for inputs that may fail individually: errors are reported at once, and the batch continues. A progress bar
/// is titled `what`; `label` names an input.
///
/// # Errors
/// The outer error of the first `work` that had one: if one result cannot be written, the next cannot either.
pub(crate) fn each_on_its_own<I: Sync, T: Send>(
    inputs: &[I],
    at_once: usize,
    what: &str,
    console: &Console,
    label: impl Fn(&I) -> String + Sync,
    work: impl Fn(&I) -> Result<anyhow::Result<T>, Problem> + Sync,
) -> Result<Vec<anyhow::Result<T>>, Problem> {
    let progress = console.progress(inputs.len(), what);
    each(inputs, at_once, |input| {
        let result = survive(|| label(input), || work(input));
        if let Ok(Err(error)) = &result {
            progress.suspend(|| console.error(error));
        }
        progress.tick();
        result
    })
}

/// Turns a panic, which is a mistake of the program, into a failure of the one input.
fn survive<T>(
    label: impl FnOnce() -> String,
    work: impl FnOnce() -> Result<anyhow::Result<T>, Problem>,
) -> Result<anyhow::Result<T>, Problem> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let message = "internal error (see above); please report it with this file";
        Ok(Err(Problem::computation(format!("{}: {message}", label())).into()))
    })
}

/// The final message of a batch: "3 fitted (2 kept), 1 failed".
pub(crate) fn tally(done: &str, kept: usize, failed: usize) -> String {
    let kept = if kept > 0 { format!(" ({kept} kept)") } else { String::new() };
    let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
    format!("{done}{kept}{failed}")
}

/// Runs `work` on a thread of the pool, so that no more than `--threads` threads compute at once.
pub(crate) fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::scope(|_| work())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order() {
        let items: Vec<usize> = (0..100).collect();
        let squares = each(&items, usize::MAX, |&n| Ok::<_, ()>(n * n)).unwrap();
        assert_eq!(squares, items.iter().map(|n| n * n).collect::<Vec<_>>());
        assert!(each(&[] as &[u8], 1, |_| Ok::<u8, ()>(0)).unwrap().is_empty());
    }

    #[test]
    fn an_error_ends_the_batch() {
        let items: Vec<usize> = (0..1000).collect();
        let started = AtomicUsize::new(0);
        let error = each(&items, usize::MAX, |&n| {
            started.fetch_add(1, Ordering::Relaxed);
            if n >= 3 { Err(n) } else { Ok(()) }
        });
        assert_eq!(error, Err(3));
        assert!(started.into_inner() < 1000);
    }

    #[test]
    fn no_more_items_are_in_work_than_may_be() {
        for at_once in [1, 2, usize::MAX] {
            let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
            each(&[(); 64], at_once, |()| {
                most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                rayon::join(thread::yield_now, thread::yield_now);
                now.fetch_sub(1, Ordering::SeqCst);
                Ok::<_, ()>(())
            })
            .unwrap();
            assert!(most.into_inner() <= rayon::current_num_threads().min(at_once));
        }
    }
}
