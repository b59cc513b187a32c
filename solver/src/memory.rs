//! Memory that a factorisation needs, and what the machine has left.
//!
//! Available is the least of `MemAvailable` in /proc/meminfo, the limit of the
//! control group (version 2, as in containers) less what its processes hold, and
//! the limit of the address space (`ulimit -v`) less what is mapped and what faer maps
//! for products of matrices. Other systems report nothing here, and nothing is refused.

use std::path::Path;

use mesh::io::read_own_text;
use serde::Serialize;

/// What a direct solution needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Need {
    /// Unknowns of the linear system.
    pub unknowns: usize,
    /// Numbers in its factor.
    pub factor_entries: usize,
    /// The factor and what is stored beside it [B].
    pub bytes: usize,
}

/// The factorisation does not fit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{} unknowns: the factor has {:.1} million entries and {} are needed, available are {}\n  use a coarser mesh, a lower degree, or a machine with more memory",
    need.unknowns, need.factor_entries as f64 / 1e6, size(need.bytes), size(*available)
)]
pub struct TooLarge {
    /// What is needed.
    pub need: Need,
    /// What is available [B].
    pub available: usize,
}

impl std::iter::Sum for Need {
    fn sum<I: Iterator<Item = Self>>(needs: I) -> Self {
        let none = Self { unknowns: 0, factor_entries: 0, bytes: 0 };
        needs.fold(none, |a, b| Self {
            unknowns: a.unknowns + b.unknowns,
            factor_entries: a.factor_entries + b.factor_entries,
            bytes: a.bytes + b.bytes,
        })
    }
}

impl Need {
    /// Whether this fits into `available` bytes, if that is known.
    ///
    /// # Errors
    /// [`TooLarge`] if it does not.
    pub fn check(self, available: Option<usize>) -> Result<(), TooLarge> {
        match available {
            Some(available) if self.bytes > available => Err(TooLarge { need: self, available }),
            _ => Ok(()),
        }
    }

    /// What a user should know before the first factorisation.
    #[must_use]
    pub fn describe(&self, available: Option<usize>) -> String {
        let of = available.map_or_else(String::new, |a| format!(" of {} available", size(a)));
        format!(
            "{} unknowns, factor of {:.1} million entries, {} of memory needed{of}",
            self.unknowns,
            self.factor_entries as f64 / 1e6,
            size(self.bytes),
        )
    }
}

fn size(bytes: usize) -> String {
    let megabytes = bytes as f64 / 1e6;
    if megabytes < 1e3 {
        format!("{megabytes:.0} MB")
    } else {
        format!("{:.2} GB", megabytes / 1e3)
    }
}

/// Memory that this process may still take [B]; none where the system does not
/// report it.
#[must_use]
pub fn available() -> Option<usize> {
    available_in(Path::new("/"))
}

fn available_in(root: &Path) -> Option<usize> {
    let limits = [machine(root), control_group(root), address_space(root)];
    limits.into_iter().flatten().min()
}

fn machine(root: &Path) -> Option<usize> {
    kilobytes(&root.join("proc/meminfo"), "MemAvailable:")
}

/// The limit less what cannot be dropped, which the page cache can.
fn control_group(root: &Path) -> Option<usize> {
    let folder = root.join("sys/fs/cgroup");
    let limit = read_own_text(&folder.join("memory.max")).ok()?.trim().parse::<usize>().ok()?;
    let held = number_after(&folder.join("memory.stat"), "anon").unwrap_or(0);
    Some(limit.saturating_sub(held))
}

fn address_space(root: &Path) -> Option<usize> {
    let text = read_own_text(&root.join("proc/self/limits")).ok()?;
    let line = text.lines().find(|l| l.starts_with("Max address space"))?;
    let limit: usize = line.split_whitespace().nth(3)?.parse().ok()?;
    let mapped = kilobytes(&root.join("proc/self/status"), "VmSize:").unwrap_or(0);
    Some(limit.saturating_sub(mapped + packed(root)))
}

/// What the product of matrices in faer (private-gemm-x86) maps in a thread, most of it never touched: twice
/// the third cache. Small problems have one such thread.
fn packed(root: &Path) -> usize {
    let cache = read_own_text(&root.join("sys/devices/system/cpu/cpu0/cache/index3/size"));
    let kib = cache.ok().and_then(|size| size.trim().strip_suffix('K')?.parse::<usize>().ok());
    2 * 1024 * kib.unwrap_or(0)
}

fn kilobytes(path: &Path, key: &str) -> Option<usize> {
    number_after(path, key).map(|kib| 1024 * kib)
}

/// The number after a key at the beginning of a line.
fn number_after(path: &Path, key: &str) -> Option<usize> {
    let text = read_own_text(path).ok()?;
    let mut lines = text.lines().map(str::split_whitespace);
    lines.find_map(|mut words| (words.next()? == key).then(|| words.next())?)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{create_dir_all, write};

    const NEED: Need = Need { unknowns: 1000, factor_entries: 5_000_000, bytes: 60_000_000 };

    #[test]
    fn what_does_not_fit_is_reported_with_numbers() {
        assert!(NEED.check(None).is_ok() && NEED.check(Some(60_000_000)).is_ok());
        let line = NEED.describe(Some(23_400_000_000));
        assert!(line.ends_with("60 MB of memory needed of 23.40 GB available"), "{line}");
        let text = NEED.check(Some(50_000_000)).expect_err("too little").to_string();
        for word in
            ["1000 unknowns", "5.0 million", "60 MB are needed", "50 MB", "coarser", "degree"]
        {
            assert!(text.contains(word), "{text}");
        }
    }

    #[test]
    fn the_least_of_all_limits_counts() {
        let root = tempfile::tempdir().expect("a folder");
        let file = |name: &str, text: &str| {
            let path = root.path().join(name);
            create_dir_all(path.parent().expect("a folder")).expect("writable");
            write(path, text).expect("writable");
        };
        let found = || available_in(root.path());
        assert_eq!(found(), None);
        file("proc/meminfo", "MemTotal: 9000 kB\nMemAvailable:    8000 kB\n");
        assert_eq!(found(), Some(8_192_000));
        file("sys/fs/cgroup/memory.max", "max\n");
        assert_eq!(found(), Some(8_192_000));
        file("sys/fs/cgroup/memory.max", "5000000\n");
        assert_eq!(found(), Some(5_000_000));
        file("sys/fs/cgroup/memory.stat", "anon 2000000\nfile 1000000\n");
        assert_eq!(found(), Some(3_000_000));
        let limits = |size: &str| {
            format!(
                "Limit  Soft Limit  Hard Limit  Units\nMax address space   {size}  unlimited  bytes\n"
            )
        };
        file("proc/self/limits", &limits("unlimited"));
        assert_eq!(found(), Some(3_000_000));
        file("proc/self/limits", &limits("2500000"));
        file("proc/self/status", "Name: solver\nVmSize:\t    1000 kB\n");
        assert_eq!(found(), Some(1_476_000));
        file("sys/devices/system/cpu/cpu0/cache/index3/size", "4K\n");
        assert_eq!(found(), Some(1_476_000 - 8192));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn linux_reports_memory() {
        assert!(available().is_some_and(|bytes| bytes > 1 << 20));
    }
}
