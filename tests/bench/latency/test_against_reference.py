"""Timings that are fair."""

import time

import pytest

from footprints_edge_bench.against_reference import interleaved_ms


def test_each_variant_runs_as_often_as_the_others():
    calls = []
    times_ms = interleaved_ms(
        {name: lambda name=name: calls.append(name) for name in "abc"}, trials=20
    )
    assert {name: len(times) for name, times in times_ms.items()} == {"a": 20, "b": 20, "c": 20}
    measured = calls[-60:]
    # In turns: after every round of three, each has run once more; and not always in one order.
    rounds = ["".join(measured[i : i + 3]) for i in range(0, 60, 3)]
    assert {"".join(sorted(r)) for r in rounds} == {"abc"}
    assert len(set(rounds)) > 1
    warm_up = calls[:-60]
    assert set(warm_up) == set("abc")


def test_a_slow_neighbour_does_not_slow_the_measurement():
    def busy(seconds):
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            pass

    quick = {"quick": lambda: busy(0.002)}
    alone = interleaved_ms(quick, 20)
    beside = interleaved_ms(quick | {"slow": lambda: busy(0.01)}, 20)
    assert min(alone["quick"]) == pytest.approx(2, rel=0.3)
    assert min(beside["quick"]) == pytest.approx(min(alone["quick"]), rel=0.3)
    assert min(beside["slow"]) == pytest.approx(10, rel=0.3)
