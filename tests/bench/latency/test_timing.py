"""Times that are fair, and what is made of them, against closed forms and numpy."""

import numpy as np
import pytest
from scipy import stats

from footprints_edge_bench.latency.timing import Trials, measure, ratio


class FakeMachine:
    """A clock that only work moves; a variant that follows another one is slow at first."""

    def __init__(self, cold_ms=0.0):
        self.now_s = 100.0
        self.cpu_s = 5.0
        self.cold_ms = cold_ms
        self.calls = []

    def variant(self, name, times_ms, threads=1):
        """Function that takes these times in turn, over and over."""
        turn = iter(range(10**9))

        def run():
            spent_ms = times_ms[next(turn) % len(times_ms)]
            if self.calls and self.calls[-1] != name:
                spent_ms += self.cold_ms
            self.calls.append(name)
            self.now_s += spent_ms / 1000
            self.cpu_s += threads * spent_ms / 1000

        return run

    def measure(self, variants, trials, **options):
        clocks = {"clock": lambda: self.now_s, "cpu_clock": lambda: self.cpu_s}
        return measure(variants, trials, **clocks, **options)


def test_the_summary_is_numpys():
    machine = FakeMachine()
    times_ms = [float(n) for n in range(1, 102)]
    run = machine.variant("a", times_ms, threads=2)
    found = machine.measure({"a": run}, 101, warm_up=0, settle_ms=0)["a"]
    assert found.times_ms == pytest.approx(times_ms)
    summary = found.summary()
    assert (summary.n, summary.warm_up) == (101, 0)
    assert summary.min_ms == pytest.approx(1)
    assert summary.mean_ms == pytest.approx(51)
    # Of 1 to 101, the p-th percentile is p + 1.
    percentiles = (summary.p50_ms, summary.p90_ms, summary.p99_ms)
    assert percentiles == pytest.approx((51, 91, 100))
    assert percentiles == pytest.approx(np.percentile(found.times_ms, [50, 90, 99]))
    assert summary.cpu_s == pytest.approx(0.102)  # two threads, 51 ms


def test_warm_up_is_not_counted():
    machine = FakeMachine()
    run = machine.variant("a", [1000.0, 500.0, 2.0, 2.0, 2.0])
    found = machine.measure({"a": run}, 3, warm_up=2, settle_ms=0)["a"]
    assert found.times_ms == pytest.approx([2, 2, 2])
    assert found.warm_up == 2


def test_the_order_is_random_and_its_seed_decides():
    def rounds(seed):
        machine = FakeMachine()
        variants = {name: machine.variant(name, [1.0]) for name in "abc"}
        machine.measure(variants, 30, warm_up=0, settle_ms=0, seed=seed)
        return ["".join(machine.calls[i : i + 3]) for i in range(0, 90, 3)]

    assert {"".join(sorted(each)) for each in rounds(0)} == {"abc"}
    assert len(set(rounds(0))) > 3
    assert rounds(0) == rounds(0) != rounds(1)


def test_a_variant_beside_others_gives_what_it_gives_alone():
    def median_ms(names, settle_ms):
        machine = FakeMachine(cold_ms=7.0)
        times_ms = {"quick": [10.0], "slow": [200.0], "tiny": [0.5]}
        variants = {name: machine.variant(name, times_ms[name]) for name in names}
        found = machine.measure(variants, 20, settle_ms=settle_ms)
        return found["quick"].summary().p50_ms

    assert median_ms(["quick"], 30) == pytest.approx(10)
    assert median_ms(["quick", "slow", "tiny"], 30) == pytest.approx(10)
    # The fake machine does punish turns: without settling the neighbours would be seen.
    assert median_ms(["quick", "slow", "tiny"], 0) == pytest.approx(17)


def test_progress_is_told_of_every_trial():
    machine = FakeMachine()
    told = []
    variants = {name: machine.variant(name, [1.0]) for name in "ab"}
    machine.measure(variants, 4, progress=told.append)
    assert sorted(told) == list("aaaabbbb")


def test_a_ratio_of_equals_is_one_and_of_doubles_two():
    times_ms = np.random.default_rng(0).gamma(9, 2, 60)
    same, doubled = ratio(times_ms, times_ms), ratio(2 * times_ms, times_ms)
    assert (same.value, same.low, same.high) == (1, 1, 1)
    # Rounds are drawn, so what both suffer in a round leaves the ratio alone.
    assert (doubled.value, doubled.low, doubled.high) == pytest.approx((2, 2, 2))


def test_the_interval_is_scipys():
    rng = np.random.default_rng(1)
    ours, theirs = rng.gamma(50, 0.2, 80), rng.gamma(30, 0.2, 80)
    found = ratio(ours, theirs)
    expected = stats.bootstrap(
        (ours, theirs),
        lambda a, b, axis=-1: np.median(a, axis=axis) / np.median(b, axis=axis),
        paired=True,
        vectorized=True,
        method="percentile",
        n_resamples=4000,
        rng=2,
    ).confidence_interval
    assert found.value == pytest.approx(np.median(ours) / np.median(theirs))
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=0.02)
    assert found.low < found.value < found.high
    assert ratio(ours, theirs) == found


def test_more_rounds_narrow_the_interval():
    rng = np.random.default_rng(3)
    ours, theirs = rng.gamma(50, 0.2, 1000), rng.gamma(30, 0.2, 1000)
    few, many = ratio(ours[:20], theirs[:20]), ratio(ours, theirs)
    assert many.high - many.low < 0.5 * (few.high - few.low)


def test_trials_that_vary_keep_their_order():
    trials = Trials((3.0, 1.0, 2.0), (0.1, 0.2, 0.3), 2)
    assert trials.summary().min_ms == 1
    assert trials.times_ms[0] == 3
