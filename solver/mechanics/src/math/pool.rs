//! Buffers that are used again.
//!
//! The system clears every page of memory that it hands out. Large buffers that come and
//! go in every factorisation are kept instead.

use std::sync::{Mutex, PoisonError};

/// Buffers shorter than this are left to the allocator.
const SHORTEST: usize = 1 << 12;

/// Buffers that nobody uses, for any thread.
pub struct Pool<T> {
    free: Mutex<Vec<Vec<T>>>,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self { free: Mutex::default() }
    }
}

impl<T: Copy> Pool<T> {
    /// A buffer of a length that is going to be overwritten: with what it had, and a value where
    /// it is new.
    pub fn overwritable(&self, len: usize, value: T) -> Vec<T> {
        if len < SHORTEST {
            return vec![value; len];
        }
        let mut buffer = self.take(len);
        buffer.truncate(len);
        buffer.resize(len, value);
        buffer
    }

    /// [`Self::overwritable`], of that length or longer. A buffer that is never cut is never filled
    /// again.
    pub fn at_least(&self, len: usize, value: T) -> Vec<T> {
        if len < SHORTEST {
            return vec![value; len];
        }
        let mut buffer = self.take(len);
        if buffer.len() < len {
            buffer.resize(len, value);
        }
        buffer
    }

    /// The smallest of the free buffers that is long enough. Where none is, the longest
    /// makes way for a new one, so that no more memory waits than was in use before.
    fn take(&self, len: usize) -> Vec<T> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let fit = (0..free.len()).filter(|&i| free[i].capacity() >= len);
        if let Some(i) = fit.min_by_key(|&i| free[i].capacity()) {
            return free.swap_remove(i);
        }
        let longest = (0..free.len()).max_by_key(|&i| free[i].capacity());
        let dropped = longest.map(|i| free.swap_remove(i));
        drop(free);
        drop(dropped);
        Vec::with_capacity(len)
    }

    /// Takes back what is not used any more.
    pub fn give(&self, buffer: Vec<T>) {
        if buffer.capacity() >= SHORTEST {
            self.free.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_come_back_and_the_best_fit_first() {
        let pool = Pool::default();
        let [small, large] = [2, 5].map(|n| pool.overwritable(n * SHORTEST, 1.0));
        let places = [small.as_ptr(), large.as_ptr()];
        pool.give(large);
        pool.give(small);
        let again = pool.overwritable(2 * SHORTEST - 1, 0.0);
        assert_eq!((again.as_ptr(), again.len()), (places[0], 2 * SHORTEST - 1));
        assert!(again.iter().all(|&v| v == 1.0));
        let other = pool.overwritable(3 * SHORTEST, 0.0);
        assert_eq!(other.as_ptr(), places[1]);
        // what is too short is dropped when something longer is made
        pool.give(again);
        let longest = pool.overwritable(9 * SHORTEST, 0.0);
        assert!(longest == vec![0.0; 9 * SHORTEST]);
        pool.give(longest);
        assert_eq!(pool.at_least(4 * SHORTEST, 1.0), vec![0.0; 9 * SHORTEST]);
        assert!(pool.free.lock().expect("no thread failed").is_empty());
    }
}
