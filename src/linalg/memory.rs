//! Available memory of the machine.

/// Bytes available without swapping; `None` if the system does not report them.
pub(super) fn available() -> Option<usize> {
    parse(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse(meminfo: &str) -> Option<usize> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: usize = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// A number of bytes in readable form: `1.3 GB`.
pub(super) fn readable(bytes: usize) -> String {
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
        assert_eq!(parse("MemTotal: 8 kB\nMemAvailable:   1234 kB\n"), Some(1234 * 1024));
        assert_eq!(parse("MemTotal: 8 kB\n"), None);
        assert_eq!(parse("MemAvailable: lots kB\n"), None);
    }

    #[test]
    fn sizes_are_readable() {
        assert_eq!(readable(12), "12 bytes");
        assert_eq!(readable(1_340_000_000), "1.3 GB");
    }
}
