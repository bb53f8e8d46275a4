//! Memory that a process may still take.

use std::fs::read_to_string;

/// Bytes that this process may still take without swapping: what the machine has, within the limits
/// of its control group (versions 1 and 2) and of its address space (`ulimit -v`); `None` if the
/// system does not report them.
pub fn available_memory() -> Option<usize> {
    let of_machine = || kibibytes(&read_to_string("/proc/meminfo").ok()?, "MemAvailable:");
    let number = |path: &str| read_to_string(path).ok()?.trim().parse::<usize>().ok();
    // Files in the cache are given back when memory is short.
    let cached = |path: &str, prefix: &str| -> usize {
        let of_file = |line: &str| {
            let (key, bytes) = line.strip_prefix(prefix)?.split_once(' ')?;
            ["active_file", "inactive_file"].contains(&key).then(|| bytes.parse::<usize>().ok())?
        };
        read_to_string(path).unwrap_or_default().lines().filter_map(of_file).sum()
    };
    let of_group = |folder: &str, [limit, used]: [&str; 2], prefix: &str| {
        let file = |name: &str| format!("/sys/fs/cgroup/{folder}{name}");
        let used = number(&file(used))?.saturating_sub(cached(&file("memory.stat"), prefix));
        Some(number(&file(limit))?.saturating_sub(used))
    };
    let two = of_group("", ["memory.max", "memory.current"], "");
    let one = of_group("memory/", ["memory.limit_in_bytes", "memory.usage_in_bytes"], "total_");
    [of_machine(), two, one, of_address_space()].into_iter().flatten().min()
}

/// What `ulimit -v` leaves; `None` without a limit.
fn of_address_space() -> Option<usize> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: usize = line.split_whitespace().next()?.parse().ok()?;
    let used = kibibytes(&read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    Some(limit.saturating_sub(used))
}

/// The bytes of a line `KEY NUMBER kB` of a file of `/proc`.
fn kibibytes(text: &str, key: &str) -> Option<usize> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: usize = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// A number of bytes in readable form: `1.3 GB`.
pub fn readable_bytes(bytes: usize) -> String {
    let bytes = bytes as f64;
    for (unit, size) in [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)] {
        if bytes >= size {
            return format!("{:.1} {unit}", bytes / size);
        }
    }
    format!("{bytes} bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_read_from_its_line() {
        assert_eq!(
            kibibytes("MemTotal: 8 kB\nMemAvailable:   1234 kB\n", "MemAvailable:"),
            Some(1234 * 1024)
        );
        assert_eq!(kibibytes("MemTotal: 8 kB\n", "MemAvailable:"), None);
        assert_eq!(kibibytes("MemAvailable: lots kB\n", "MemAvailable:"), None);
    }

    #[test]
    fn sizes_are_readable() {
        assert_eq!(readable_bytes(12), "12 bytes");
        assert_eq!(readable_bytes(1_340_000_000), "1.3 GB");
    }
}
