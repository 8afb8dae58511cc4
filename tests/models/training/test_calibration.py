"""Calibration: what a logistic fit finds, and that it becomes part of the network."""

import json

import numpy as np
import pytest
import torch
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.networks.registry import NETWORKS
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, YES, Sample
from footprints_edge_models.training.calibration import MaskPixels, calibrate, fit
from footprints_edge_models.training.calibration_data import halves_of
from footprints_edge_models.training.schedule import TrainingError


def test_the_line_that_made_the_labels_is_found():
    """Labels drawn with probability sigmoid(0.5 x - 1): that is the line."""
    rng = np.random.default_rng(0)
    logits = rng.normal(0, 3, 60000).astype(np.float32)
    is_true = rng.random(len(logits)) < 1 / (1 + np.exp(-(0.5 * logits - 1)))
    pixels = MaskPixels(logits, is_true)
    found = fit(pixels, pixels)
    assert (found.scale, found.bias) == pytest.approx((0.5, -1.0), abs=0.03)
    assert found.after < found.before
    predicted = 0.5 * logits - 1 > 0
    assert abs((logits * found.scale + found.bias > 0).mean() - predicted.mean()) < 0.01


@pytest.mark.parametrize(
    ("logits", "labels", "says"),
    [([1, 2], [1, 1], "on and off"), ([1, 2, 3, 4], [1, 1, 0, 0], "lower where")],
)
def test_labels_that_do_not_suffice_are_refused(logits, labels, says):
    pixels = MaskPixels(np.array(logits, np.float32), np.array(labels, bool))
    good = MaskPixels(np.array([-1, 1], np.float32), np.array([False, True]))
    with pytest.raises(TrainingError, match=says):
        fit(pixels, good)


def test_the_fit_is_scored_on_other_pixels():
    """On those, labels are the other way round: the fit makes it worse there."""
    rng = np.random.default_rng(0)
    logits = rng.normal(0, 1, 5000).astype(np.float32)
    is_true = rng.random(len(logits)) < 1 / (1 + np.exp(-4 * logits))
    found = fit(MaskPixels(logits, is_true), MaskPixels(logits, ~is_true))
    assert found.scale == pytest.approx(4, abs=0.5)
    assert found.after > found.before + 0.5


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
    calibrate(network, [photo(0)], [photo(1)], (64, 64))
    for scale, raw in network.scales(image).items():
        for channel, (factor, summand) in enumerate([(2.0, 0.5), (0.25, -1.0), (1, 0), (1, 0)]):
            torch.testing.assert_close(
                raw[:, channel], before[scale][:, channel] * factor + summand, rtol=1e-4, atol=1e-4
            )


def test_there_must_be_photos_to_fit_on_and_others_to_score():
    network = NETWORKS["edge"].build().eval()
    with pytest.raises(TrainingError, match="1 and 0"):
        calibrate(network, [photo(0)], [], (64, 64))


def test_hand_drawn_photos_are_read_and_shared_out_by_kind(tmp_path):
    (tmp_path / "images").mkdir()
    truth = []
    for kind in ("street", "indoor"):
        for number in range(2):
            name = f"{kind}_{number}.png"
            Image.fromarray(np.zeros((64, 96, 3), np.uint8)).save(tmp_path / "images" / name)
            square = [[[20, 40], [60, 40], [60, 60], [20, 60]]]
            truth.append(
                {"name": name, "kind": kind, "size_wh": [96, 64], "visible": [], "ignore": [],
                 "ground": [[[0, 32], [96, 32], [96, 64], [0, 64]]], "footprints": square}
            )  # fmt: skip
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    one, two = halves_of(tmp_path)
    assert [sample.name.split("/")[1] for sample in one] == ["indoor_0.png", "street_0.png"]
    assert [sample.name.split("/")[1] for sample in two] == ["indoor_1.png", "street_1.png"]
    ground = one[0].ground
    assert (ground[:31] == NO).all()
    assert (ground[42:58, 22:58] == FOOTPRINT).all()
    assert (ground[33:39] == YES).all()
    assert (one[0].visible_ground == NO).all()
    with pytest.raises(DatasetError, match=r"truth\.json"):
        halves_of(tmp_path / "images")


class Fit:
    """As :class:`Calibration`."""

    def __init__(self, scale, bias):
        self.scale, self.bias = scale, bias
