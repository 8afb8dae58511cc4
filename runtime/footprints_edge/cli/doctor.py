"""The checks of `fp-models doctor`: machine facts, timing and advice."""

import platform
from importlib.metadata import version
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from footprints_edge.engines.onnxruntime_engine import available_providers, runtime
from footprints_edge.foundation.cores import usable_cores
from footprints_edge.foundation.version import __version__
from footprints_edge.model import Model

RUNS = 20
_SIZE = (256, 448)
_VNNI = {"avx512_vnni", "avx_vnni"}
_DOT_PRODUCT = {"asimddp", "i8mm"}
_REPORTED_FLAGS = ("avx2", "avx512f", "neon", "asimd", *sorted(_VNNI), *sorted(_DOT_PRODUCT))


def machine_facts() -> dict[str, str]:
    """Versions, processor, cores and providers, as lines to print."""
    flags = cpu_flags()
    return {
        "footprints-edge": __version__,
        "python": platform.python_version(),
        "runtime": f"{runtime()}, numpy {np.__version__}, pillow {version('pillow')}",
        "system": platform.platform(),
        "processor": f"{_cpu_model()} ({platform.machine()})",
        "instructions": " ".join(flag for flag in _REPORTED_FLAGS if flag in flags) or "unknown",
        "usable cores": str(usable_cores()),
        "providers": ", ".join(available_providers()),
    }


def time_model(model: Model) -> str:
    """Times the network alone on noise, after a warm-up."""
    height, width = model.engine.input_size or _SIZE
    noise = np.random.default_rng(0).integers(0, 256, (1, height, width, 3), np.uint8)
    times_ms = []
    for _ in range(RUNS + 3):
        start = perf_counter()
        model.engine.run(noise)
        times_ms.append(1000 * (perf_counter() - start))
    measured = times_ms[3:]
    return (
        f"median {median(measured):.1f} ms, fastest {min(measured):.1f} ms of {RUNS} runs "
        f"at {height} x {width} with {model.engine.threads} thread(s)"
    )


def advice(precision: str, flags: frozenset[str] | None = None) -> list[str]:
    """Advice on speed and accuracy on this machine; one line says so if there is none."""
    flags = cpu_flags() if flags is None else flags
    lines = []
    if precision == "int8" and "avx2" in flags and not flags & _VNNI:
        lines.append(
            "this processor has no VNNI instructions: int8 gains less, and may saturate; a model "
            "converted with --target x86-avx2 does not saturate"
        )
    if precision == "int8" and "asimd" in flags and not flags & _DOT_PRODUCT:
        lines.append("this processor has no dot product instructions: int8 gains less")
    if precision == "fp32":
        lines.append("this model is fp32: an int8 conversion is several times faster")
    if usable_cores() == 1:
        lines.append("only one core is usable: a second one nearly doubles the speed")
    return lines or ["none: this machine suits this model"]


def cpu_flags(cpuinfo: Path = Path("/proc/cpuinfo")) -> frozenset[str]:
    """The processor's instruction sets; empty if the system does not report them."""
    return frozenset((_cpuinfo(cpuinfo, "flags") or _cpuinfo(cpuinfo, "Features")).split())


def _cpu_model() -> str:
    return _cpuinfo(Path("/proc/cpuinfo"), "model name") or platform.processor() or "unknown"


def _cpuinfo(cpuinfo: Path, key: str) -> str:
    try:
        lines = cpuinfo.read_text().splitlines()
    except OSError:
        return ""
    values = (line.partition(":")[2].strip() for line in lines if line.split(":")[0].strip() == key)
    return next(values, "")
