//! Many pieces of work at once, their results in order.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does `work` with every item and returns the results in the order of the items, or the error of the first item (in
/// their order) that ended the batch.
///
/// At most as many items are in work as there are threads to compute: with work stealing alone, a thread that waits for a
/// part of one item would start another, and each item in work holds a measured file in memory. After an error no new item
/// is started.
///
/// # Errors
/// The error of the first item that failed.
pub(crate) fn each<I: Sync, T: Send, E: Send>(
    items: &[I],
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
    let threads = rayon::current_num_threads().min(items.len());
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(worker);
        }
        worker();
    });
    // Items that were never started lie behind the one that failed.
    results.into_iter().map_while(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order() {
        let items: Vec<usize> = (0..100).collect();
        let squares = each(&items, |&n| Ok::<_, ()>(n * n)).unwrap();
        assert_eq!(squares, items.iter().map(|n| n * n).collect::<Vec<_>>());
        assert!(each(&[] as &[u8], |_| Ok::<u8, ()>(0)).unwrap().is_empty());
    }

    #[test]
    fn an_error_ends_the_batch() {
        let items: Vec<usize> = (0..1000).collect();
        let started = AtomicUsize::new(0);
        let error = each(&items, |&n| {
            started.fetch_add(1, Ordering::Relaxed);
            if n >= 3 { Err(n) } else { Ok(()) }
        });
        assert_eq!(error, Err(3));
        assert!(started.into_inner() < 1000);
    }

    #[test]
    fn no_more_items_are_in_work_than_threads() {
        let (now, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        each(&[(); 64], |()| {
            most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
            rayon::join(thread::yield_now, thread::yield_now);
            now.fetch_sub(1, Ordering::SeqCst);
            Ok::<_, ()>(())
        })
        .unwrap();
        assert!(most.into_inner() <= rayon::current_num_threads());
    }
}
