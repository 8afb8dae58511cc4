"""Facts about the machine that a measurement was made on."""

import os
import platform
import subprocess
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from footprints_edge.cli.doctor import cpu_flags
from footprints_edge.foundation.cores import usable_cores

PACKAGES = (
    "footprints-edge",
    "numpy",
    "pillow",
    "onnxruntime",
    "torch",
    "openvino",
    "nncf",
    "ncnn",
    "ai-edge-litert",
)
_FLAGS = (
    "avx2",
    "fma",
    "avx512f",
    "avx512_vnni",
    "avx_vnni",
    "avx_vnni_int8",
    "avx512_bf16",
    "avx512_fp16",
    "amx_int8",
    "amx_bf16",
    "asimd",
    "asimddp",
    "i8mm",
    "bf16",
)


@dataclass(frozen=True)
class Machine:
    """Facts about a machine; "unknown" where the system does not report them.

    Attributes:
        cpu: name of the processor.
        flags: its instruction sets that matter for networks.
        usable_cores: number of cores that this process may use.
        machine_cores: number of cores that the system reports.
        governor: frequency governor of the first core.
        load: load average of the last minute before the measurement; None if unknown.
        memory_bytes: memory of the machine; None if unknown.
        system: operating system.
        python: version of Python.
        versions: versions of the installed packages.
        commit: commit of the checkout that the code is from, with "+" if files were changed.
    """

    cpu: str
    flags: tuple[str, ...]
    usable_cores: int
    machine_cores: int
    governor: str
    load: float | None
    memory_bytes: int | None
    system: str
    python: str
    versions: dict[str, str]
    commit: str

    def as_markdown(self) -> str:
        """One paragraph."""
        load = "unknown" if self.load is None else f"{self.load:.1f}"
        packages = ", ".join(f"{name} {number}" for name, number in self.versions.items())
        return (
            f"{self.cpu} ({' '.join(self.flags) or 'flags unknown'}), {self.usable_cores} of "
            f"{self.machine_cores} cores, governor {self.governor}, load before the run {load}, "
            f"{self.system}; Python {self.python}, {packages}; commit {self.commit}."
        )


def machine(root: Path = Path("/")) -> Machine:
    """Describes this machine.

    Args:
        root: folder that holds ``proc`` and ``sys``.
    """
    found = cpu_flags(root / "proc/cpuinfo")
    memory_kb = _field(root / "proc/meminfo", "MemTotal").removesuffix("kB").strip()
    return Machine(
        cpu=_field(root / "proc/cpuinfo", "model name") or platform.processor() or "unknown",
        flags=tuple(flag for flag in _FLAGS if flag in found),
        usable_cores=usable_cores(),
        machine_cores=os.cpu_count() or 1,
        governor=_first_line(root / "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        load=_load(root),
        memory_bytes=1024 * int(memory_kb) if memory_kb.isdecimal() else None,
        system=platform.platform(),
        python=platform.python_version(),
        versions=versions(),
        commit=commit(Path(__file__).parent),
    )


def versions() -> dict[str, str]:
    """Versions of the ``PACKAGES`` that are installed."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def commit(folder: Path) -> str:
    """Commit of a folder, with "+" if files were changed; "unknown" without git."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(folder), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        return git("rev-parse", "--short=12", "HEAD") + ("+" if git("status", "--short") else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _load(root: Path) -> float | None:
    try:
        return float((root / "proc/loadavg").read_text().split()[0])
    except (OSError, ValueError, IndexError):
        return None


def _first_line(path: Path) -> str:
    try:
        return path.read_text().splitlines()[0].strip()
    except (OSError, IndexError):
        return "unknown"


def _field(path: Path, key: str) -> str:
    """The first value of a key in a file of "key: value" lines; empty if there is none."""
    try:
        lines = path.read_text().splitlines()
    except OSError:
        return ""
    values = (line.partition(":")[2].strip() for line in lines if line.split(":")[0].strip() == key)
    return next(values, "")
