"""Single-stream timing: one frame at a time, contenders in turns, and what the times say.

The next frame starts when the last one ends. Contenders take turns in random order, so that
whatever else the machine does hits all alike. Before each timed frame a contender runs untimed
until its caches are warm and its predecessor's threads are asleep: what it gives beside others is
what it gives alone.
"""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

SETTLE_MS = 30.0
"""Untimed frames before a timed one last at least this long; waiting threads of other engines give
up sooner."""

RESAMPLES = 2000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Trials:
    """What was measured of one contender, in the order of the rounds.

    Attributes:
        times_ms: wall time of every timed frame.
        cpu_s: seconds of processor time of every timed frame, all threads of the process together.
        warm_up: untimed frames before the first timed one; those that settle it are not counted.
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
    """A contender's times in few numbers; percentiles are interpolated linearly.

    Attributes:
        n: timed frames.
        warm_up: untimed frames before them.
        min_ms: fastest.
        mean_ms: mean.
        p50_ms: median.
        p90_ms: 90th percentile, the figure that MLPerf's single-stream scenario states.
        p99_ms: 99th percentile; of few frames it is nearly the slowest.
        cpu_s: mean processor time a frame.
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
    """How many times as long one contender takes as another.

    Attributes:
        value: ratio of the medians.
        low: lower end of its 95 % bootstrap interval.
        high: upper end.
    """

    value: float
    low: float
    high: float


def measure(
    contenders: Mapping[str, Callable[[], object]],
    trials: int,
    *,
    warm_up: int = 2,
    settle_ms: float = SETTLE_MS,
    seed: int = 0,
    clock: Callable[[], float] = perf_counter,
    cpu_clock: Callable[[], float] = process_time,
    progress: Callable[[str], None] | None = None,
) -> dict[str, Trials]:
    """Times contenders against each other.

    Args:
        contenders: by name, what runs one frame.
        trials: rounds; in each, every contender is timed once.
        warm_up: untimed frames of each contender before the first round.
        settle_ms: untimed frames before each timed one go on for so long; 0 for none.
        seed: of the order in each round.
        clock: seconds of wall time.
        cpu_clock: seconds of this process's processor time.
        progress: told the name of each contender after each of its trials.
    """
    for run in contenders.values():
        for _ in range(warm_up):
            run()
    times_ms: dict[str, list[float]] = {name: [] for name in contenders}
    cpu_s: dict[str, list[float]] = {name: [] for name in contenders}
    order = random.Random(seed)
    for _ in range(trials):
        for name in order.sample(list(contenders), len(contenders)):
            run = contenders[name]
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
    return {name: Trials(tuple(times_ms[name]), tuple(cpu_s[name]), warm_up) for name in contenders}


def interleaved_ms(
    variants: dict[str, Callable[[], object]], trials: int, seed: int = 0
) -> dict[str, list[float]]:
    """Milliseconds of every trial of every variant, in turns, after a warm-up, nothing between."""
    measured = measure(variants, trials, settle_ms=0, seed=seed)
    return {name: list(found.times_ms) for name, found in measured.items()}


def ratio(times_ms: Sequence[float], against_ms: Sequence[float], *, seed: int = 0) -> Ratio:
    """Ratio of the medians of two contenders of one run, with its bootstrap interval.

    Rounds are drawn, not trials: two trials of one round were neighbours in time and share what
    else the machine did.

    Args:
        times_ms: of each round.
        against_ms: of the same rounds.
        seed: of the resampling.
    """
    ours, theirs = np.asarray(times_ms, float), np.asarray(against_ms, float)
    drawn = np.random.default_rng(seed).integers(0, len(ours), (RESAMPLES, len(ours)))
    ratios = np.median(ours[drawn], axis=1) / np.median(theirs[drawn], axis=1)
    low, high = np.quantile(ratios, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]).tolist()
    return Ratio(float(np.median(ours) / np.median(theirs)), low, high)
