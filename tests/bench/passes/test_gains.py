"""Gains of passes: rounds are compared, not minutes of a busy machine."""

import pytest
import torch

from footprints_edge_bench.passes import gains as passes
from footprints_edge_bench.passes.gains import (
    AS_EXPORTED,
    gains_as_markdown,
    measure_gains,
    summarise,
)


def test_ratios_are_of_the_same_round():
    busy = [1, 1, 10, 1, 1]  # the third round met another program
    gains = summarise(
        {
            AS_EXPORTED: [100 * b for b in busy],
            "one": [50 * b for b in busy],
            "two": [40 * b for b in busy],
        }
    )
    assert [gain.name for gain in gains] == [AS_EXPORTED, "one", "two"]
    assert [gain.of_before for gain in gains] == pytest.approx([1, 0.5, 0.8])
    assert [gain.of_first for gain in gains] == pytest.approx([1, 0.5, 0.4])
    assert [gain.min_ms for gain in gains] == [100, 50, 40]
    assert "| two | 40.0 | 40.0 | 0.80 | 0.40 |" in gains_as_markdown(gains)


@pytest.mark.parametrize(
    ("precision", "applied"),
    [
        (
            "fp32",
            ["few_outputs_by_blocks", "upsample_rows_in_convolution", "elu_as_exponential"],
        ),
        (
            "int8",
            [
                "few_outputs_by_blocks",
                "pad_and_resize_on_bytes",
                "elu_on_bytes",
                "upsample_by_expanding",
            ],
        ),
    ],
)
@pytest.mark.usefixtures("graphs_once")
def test_each_pass_of_a_precision_has_its_row(monkeypatch, precision, applied):
    """The edge network: small, and each of its files runs."""
    times_ms = {}

    def once(runs, trials):
        assert trials == 3
        for name, run in runs.items():
            (maps,) = run()
            assert maps.shape == (1, 4, 64, 96)
            times_ms[name] = [1.0] * trials
        return times_ms

    monkeypatch.setattr(passes, "interleaved_ms", once)
    torch.manual_seed(0)  # of both precisions the same weights, and one graph
    gains = measure_gains("edge", precision, (64, 96), threads=1, trials=3)
    assert [gain.name for gain in gains] == [AS_EXPORTED, *applied]
