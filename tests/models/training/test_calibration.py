"""Calibration: what a logistic fit finds, and that it becomes part of the network."""

import numpy as np
import pytest
import torch

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.networks.registry import NETWORKS
from footprints_edge_models.sample import NO, UNKNOWN, YES, Sample
from footprints_edge_models.training.calibration import calibrate, fit
from footprints_edge_models.training.schedule import TrainingError


def test_the_line_that_made_the_labels_is_found():
    """Labels drawn with probability sigmoid(0.5 x - 1): that is the line."""
    rng = np.random.default_rng(0)
    logits = rng.normal(0, 3, 60000).astype(np.float32)
    is_true = rng.random(len(logits)) < 1 / (1 + np.exp(-(0.5 * logits - 1)))
    found = fit(logits, is_true)
    assert (found.scale, found.bias) == pytest.approx((0.5, -1.0), abs=0.03)
    assert found.after < found.before
    predicted = 0.5 * logits - 1 > 0
    assert abs((logits * found.scale + found.bias > 0).mean() - predicted.mean()) < 0.01


@pytest.mark.parametrize(
    ("logits", "labels", "says"),
    [([1, 2], [1, 1], "on and off"), ([1, 2, 3, 4], [1, 1, 0, 0], "lower where")],
)
def test_labels_that_do_not_suffice_are_refused(logits, labels, says):
    with pytest.raises(TrainingError, match=says):
        fit(np.array(logits, np.float32), np.array(labels, bool))


def photo(index):
    """A picture whose brightness says what it is, with mistakes; its top is unknown."""
    rng = np.random.default_rng(index)
    image = rng.integers(0, 256, (64, 64, 3)).astype(np.uint8)
    label = np.where(rng.random((64, 64)) < 0.3, YES, NO).astype(np.uint8)
    label[:8] = UNKNOWN
    return Sample("a", image, Intrinsics.assumed((64, 64)), label, label)


@pytest.mark.parametrize("name", NETWORKS)
@torch.no_grad()
def test_it_becomes_part_of_the_network(name, monkeypatch):
    torch.manual_seed(0)
    network = NETWORKS[name].build().eval()
    image = torch.rand(1, 3, 64, 64)
    before = network.scales(image)
    monkeypatch.setattr(
        "footprints_edge_models.training.calibration.fit", lambda *_: next(fits), raising=True
    )
    fits = iter([Fit(2.0, 0.5), Fit(0.25, -1.0)])
    calibrate(network, [photo(0)], (64, 64))
    for scale, raw in network.scales(image).items():
        for channel, (factor, summand) in enumerate([(2.0, 0.5), (0.25, -1.0), (1, 0), (1, 0)]):
            torch.testing.assert_close(
                raw[:, channel], before[scale][:, channel] * factor + summand, rtol=1e-4, atol=1e-4
            )


class Fit:
    """As :class:`Calibration`."""

    def __init__(self, scale, bias):
        self.scale, self.bias = scale, bias
