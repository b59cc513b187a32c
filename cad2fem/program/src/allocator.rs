//! What a program does when the system gives it no memory: it says so, and ends with exit code 1.
//!
//! Without this Rust would abort it. Estimates come before: this is for what none foresees.

use std::alloc::{GlobalAlloc, Layout};
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// An allocator that ends the program where the other, `A`, has no memory left.
#[derive(Debug)]
pub struct OrEnd<A>(pub A);

// SAFETY: all is done by the other allocator, whose answers are only looked at.
#[allow(unsafe_code, reason = "the trait is unsafe")]
unsafe impl<A: GlobalAlloc> GlobalAlloc for OrEnd<A> {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        or_end(unsafe { self.0.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        or_end(unsafe { self.0.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        or_end(unsafe { self.0.realloc(place, layout, size) }, size)
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { self.0.dealloc(place, layout) }
    }
}

fn or_end(place: *mut u8, size: usize) -> *mut u8 {
    if place.is_null() {
        end(size);
    }
    place
}

/// Nothing in here asks for memory.
#[cold]
fn end(size: usize) -> ! {
    static ENDS: AtomicBool = AtomicBool::new(false);
    if ENDS.swap(true, Ordering::Relaxed) {
        // another thread speaks
        std::thread::sleep(Duration::from_secs(1));
    } else {
        let _ = writeln!(
            std::io::stderr(),
            "out of memory: {size} bytes more are not to be had; use a coarser mesh, fewer threads, or a \
             machine with more memory"
        );
        mesh::io::remove_unfinished_files();
    }
    // what is run at the end in order may ask for memory
    system::end_now(1)
}
