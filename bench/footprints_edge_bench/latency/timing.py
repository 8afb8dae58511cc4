"""Single-stream timing: one frame at a time, variants in turns, with statistics of the times.

The next frame starts when the last one ends. Variants take turns in random order, so load from
other programs affects all of them alike. Before each timed frame, a variant runs untimed until its
caches are warm and its predecessor's threads are asleep. So interleaving does not change its times.
"""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

SETTLE_MS = 30.0
"""Minimum duration of the untimed frames before a timed one. Spinning threads of other engines give
up sooner."""

RESAMPLES = 2000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Trials:
    """Measurements of one variant, in the order of the rounds.

    Attributes:
        times_ms: wall time of every timed frame.
        cpu_s: processor time of every timed frame, seconds, all threads of the process together.
        warm_up: untimed frames before the first round.
    """

    times_ms: tuple[float, ...]
    cpu_s: tuple[float, ...]
    warm_up: int

    def summary(self) -> "TimingSummary":
        """Percentiles and means of the trials."""
        p50, p90, p99 = np.percentile(self.times_ms, [50, 90, 99]).tolist()
        return TimingSummary(
            n=len(self.times_ms),
            warm_up=self.warm_up,
            min_ms=min(self.times_ms),
            mean_ms=float(np.mean(self.times_ms)),
            p50_ms=p50,
            p90_ms=p90,
            p99_ms=p99,
            cpu_s=float(np.mean(self.cpu_s)),
        )


@dataclass(frozen=True)
class TimingSummary:
    """Statistics of a variant's times; percentiles are interpolated linearly.

    Attributes:
        n: number of timed frames.
        warm_up: untimed frames before the first round.
        min_ms: fastest frame.
        mean_ms: mean.
        p50_ms: median.
        p90_ms: 90th percentile, which MLPerf's single-stream scenario reports.
        p99_ms: 99th percentile; with few frames, nearly the slowest.
        cpu_s: mean processor time per frame, seconds.
    """

    n: int
    warm_up: int
    min_ms: float
    mean_ms: float
    p50_ms: float
    p90_ms: float
    p99_ms: float
    cpu_s: float


@dataclass(frozen=True)
class Ratio:
    """Time of one variant as a multiple of another's.

    Attributes:
        value: ratio of the medians.
        low: lower end of its 95 % bootstrap interval.
        high: upper end of that interval.
    """

    value: float
    low: float
    high: float


def measure(
    variants: Mapping[str, Callable[[], object]],
    trials: int,
    *,
    warm_up: int = 2,
    settle_ms: float = SETTLE_MS,
    seed: int = 0,
    clock: Callable[[], float] = perf_counter,
    cpu_clock: Callable[[], float] = process_time,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Trials]:
    """Times variants in turns.

    Args:
        variants: functions that run one frame, by name.
        trials: number of rounds; each times every variant once.
        warm_up: untimed frames of each variant before the first round.
        settle_ms: minimum duration of the untimed frames before each timed one; 0 for none.
        seed: seed of the order in each round.
        clock: wall time, seconds.
        cpu_clock: processor time of this process, seconds.
        progress: called with the name of a variant after each of its trials.
    """
    for run in variants.values():
        for _ in range(warm_up):
            run()
    times_ms: dict[str, list[float]] = {name: [] for name in variants}
    cpu_s: dict[str, list[float]] = {name: [] for name in variants}
    order = random.Random(seed)
    for _ in range(trials):
        for name in order.sample(list(variants), len(variants)):
            run = variants[name]
            settled = clock() + settle_ms / 1000
            while clock() < settled:
                run()
            cpu_start, start = cpu_clock(), clock()
            run()
            end, cpu_end = clock(), cpu_clock()
            times_ms[name].append(1000 * (end - start))
            cpu_s[name].append(cpu_end - cpu_start)
            if progress is not None:
                progress(name)
    return {name: Trials(tuple(times_ms[name]), tuple(cpu_s[name]), warm_up) for name in variants}


def interleaved_ms(
    variants: dict[str, Callable[[], object]], trials: int, seed: int = 0
) -> dict[str, list[float]]:
    """Times of every trial of every variant, in turns, without settling between them."""
    measured = measure(variants, trials, settle_ms=0, seed=seed)
    return {name: list(found.times_ms) for name, found in measured.items()}


def ratio(times_ms: Sequence[float], against_ms: Sequence[float], *, seed: int = 0) -> Ratio:
    """Ratio of the medians of two variants of one run, with its bootstrap interval.

    The bootstrap resamples rounds, not trials: the trials of one round ran next to each other and
    share the load of the machine.

    Args:
        times_ms: times of one variant by round.
        against_ms: times of the other variant in the same rounds.
        seed: seed of the resampling.
    """
    ours, theirs = np.asarray(times_ms, float), np.asarray(against_ms, float)
    drawn = np.random.default_rng(seed).integers(0, len(ours), (RESAMPLES, len(ours)))
    ratios = np.median(ours[drawn], axis=1) / np.median(theirs[drawn], axis=1)
    low, high = np.quantile(ratios, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]).tolist()
    return Ratio(float(np.median(ours) / np.median(theirs)), low, high)
