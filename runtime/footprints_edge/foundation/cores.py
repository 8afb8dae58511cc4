"""The number of processor cores that this process may use."""

import math
import os
from pathlib import Path

_CGROUPS = Path("/sys/fs/cgroup")


def usable_cores() -> int:
    """Cores in the process's affinity mask, capped by the container's CPU quota.

    `os.cpu_count` counts the whole machine; more threads than usable cores wait for each other.
    """
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # macOS and Windows do not report an affinity
        cores = os.cpu_count() or 1
    return max(1, math.ceil(min(cores, _quota_cores(_CGROUPS))))


def _quota_cores(root: Path) -> float:
    """The container's CPU quota in cores, from cgroup v2 or v1; infinite without a quota."""
    try:
        quota, period = (root / "cpu.max").read_text().split()
    except (OSError, ValueError):
        try:
            quota = (root / "cpu/cpu.cfs_quota_us").read_text()
            period = (root / "cpu/cpu.cfs_period_us").read_text()
        except OSError:
            return math.inf
    try:
        quota_us, period_us = int(quota), int(period)
    except ValueError:  # "max": no quota
        return math.inf
    return quota_us / period_us if quota_us > 0 and period_us > 0 else math.inf
