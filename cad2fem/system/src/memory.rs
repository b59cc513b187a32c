//! Memory that Linux has left, by its tables: the least of `MemAvailable` in /proc/meminfo, the limit of the control
//! group (version 2, as in containers) less what its processes hold, and the limit of the address space (`ulimit -v`)
//! less what is mapped and what faer maps for products of matrices.

// the tables of the system are no files of a user, and none is too large
use std::fs::read_to_string;
use std::path::Path;

/// Memory that this process may still take [B], by the tables below a folder; none where there are no such tables.
pub(crate) fn available_in(root: &Path) -> Option<usize> {
    let limits = [machine(root), control_group(root), address_space(root)];
    limits.into_iter().flatten().min()
}

fn machine(root: &Path) -> Option<usize> {
    kibibytes(&root.join("proc/meminfo"), "MemAvailable:")
}

/// The limit less what cannot be dropped, which the page cache can.
fn control_group(root: &Path) -> Option<usize> {
    let folder = root.join("sys/fs/cgroup");
    let limit = read_to_string(folder.join("memory.max")).ok()?.trim().parse::<usize>().ok()?;
    let held = number_after(&folder.join("memory.stat"), "anon").unwrap_or(0);
    Some(limit.saturating_sub(held))
}

fn address_space(root: &Path) -> Option<usize> {
    let text = read_to_string(root.join("proc/self/limits")).ok()?;
    let line = text.lines().find(|l| l.starts_with("Max address space"))?;
    let limit: usize = line.split_whitespace().nth(3)?.parse().ok()?;
    let mapped = kibibytes(&root.join("proc/self/status"), "VmSize:").unwrap_or(0);
    Some(limit.saturating_sub(mapped + packed(root)))
}

/// What the product of matrices in faer (private-gemm-x86) maps in a thread, most of it never touched: twice
/// the third cache. Small problems have one such thread.
fn packed(root: &Path) -> usize {
    let cache = read_to_string(root.join("sys/devices/system/cpu/cpu0/cache/index3/size"));
    let kib = cache.ok().and_then(|size| size.trim().strip_suffix('K')?.parse::<usize>().ok());
    2 * 1024 * kib.unwrap_or(0)
}

/// A number of kibibytes after a key [B].
pub(crate) fn kibibytes(path: &Path, key: &str) -> Option<usize> {
    number_after(path, key).map(|kib| 1024 * kib)
}

/// The number after a key at the beginning of a line.
fn number_after(path: &Path, key: &str) -> Option<usize> {
    let text = read_to_string(path).ok()?;
    let mut lines = text.lines().map(str::split_whitespace);
    lines.find_map(|mut words| (words.next()? == key).then(|| words.next())?)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{create_dir_all, write};

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
}
