"""The paper's loss: the published implementation's numbers, and closed forms."""

import json
import math

import numpy as np
import pytest
import torch

from footprints_edge_models.data.targets import Targets
from footprints_edge_models.networks.channels import depth_to_disparity
from footprints_edge_models.training.losses import (
    class_balance,
    dice_loss,
    focal_factor,
    ground_weights,
    losses,
    multiscale_losses,
    relative_depth_loss,
)

SCALES = ("1/1", "1/2", "1/4", "1/8")
NAMES = {
    "visible_ground": "visible_ground",
    "ground": "all_ground",
    "visible_depth": "depth",
    "ground_depth": "ground_depth",
    "loss": "loss",
}


def nothing_known(*shape):
    """Targets that say nothing; keywords of `with_targets` fill them."""
    return {name: torch.zeros(shape) for name in Targets.__dataclass_fields__}


def with_targets(*shape, **known):
    filled = nothing_known(*shape)
    filled.update({name: torch.as_tensor(value).float() for name, value in known.items()})
    filled["ground_weight"] = filled["ground"]
    return Targets(**filled)


def raw_with(channel, values):
    """Raw channels (1, 4, H, W), 0.5 but for one channel."""
    raw = torch.full((1, 4, *values.shape), 0.5)
    raw[0, channel] = values
    return raw


@pytest.fixture(scope="module")
def inputs(shared):
    with np.load(shared / "fixtures" / "reference" / "loss_inputs.npz") as arrays:
        return {name: torch.from_numpy(array) for name, array in arrays.items()}


@pytest.fixture(scope="module")
def expected(shared):
    return json.loads((shared / "fixtures" / "reference" / "loss_expected.json").read_text())


def published_targets(inputs, prior):
    ones = torch.ones_like(inputs["target_depth"])
    return Targets(
        visible_ground=inputs["target_visible_ground"],
        visible_ground_valid=ones,
        ground=inputs["target_all_ground"],
        ground_weight=inputs["target_all_ground"],
        untraversable=inputs["target_depth_mask"],
        unknown_weight=prior * ones,
        moving=inputs["target_moving_object_mask"],
        visible_depth_m=inputs["target_depth"],
        ground_depth_m=inputs["target_ground_depth"],
    )


@pytest.mark.parametrize("prior", ["0.25", "0.0", "1.0"])
def test_the_published_losses(inputs, expected, prior):
    targets = published_targets(inputs, float(prior))
    raw = {scale: inputs[f"prediction_{scale.replace('/', '_')}"] for scale in SCALES}
    for scale in SCALES:
        found = losses(raw[scale], targets)
        for ours, theirs in NAMES.items():
            value = expected[prior][f"{theirs}|{scale}"]
            assert found[ours].item() == pytest.approx(value, abs=1e-5), (ours, scale)
    total = multiscale_losses(raw, targets)["loss"].item()
    assert total == pytest.approx(expected[prior]["loss"], abs=1e-5)


def test_where_nothing_is_known_nothing_is_learned():
    raw = torch.randn(2, 4, 6, 8).sigmoid().requires_grad_()
    found = losses(raw, with_targets(2, 6, 8))
    assert {name: value.item() for name, value in found.items()} == dict.fromkeys(found, 0.0)
    found["loss"].backward()
    assert torch.equal(raw.grad, torch.zeros_like(raw))


def test_only_known_pixels_get_a_gradient():
    known = torch.zeros(1, 6, 8)
    known[0, 2:4, 3:6] = 1
    raw = torch.rand(1, 4, 6, 8, requires_grad=True)
    targets = with_targets(
        1, 6, 8, visible_ground_valid=known, untraversable=known, ground_depth_m=7 * known
    )
    losses(raw, targets)["loss"].backward()
    touched = raw.grad[0] != 0
    for channel in (0, 1, 3):
        assert torch.equal(touched[channel], known[0] > 0), channel
    assert not touched[2].any()


def test_cross_entropy_of_a_known_visible_pixel_over_all_pixels():
    known = torch.zeros(1, 2, 2)
    known[0, 0, 0] = 1
    logits = torch.tensor([[math.log(3), 5.0], [5.0, 5.0]])
    walkable = losses(
        raw_with(0, logits),
        with_targets(1, 2, 2, visible_ground=known, visible_ground_valid=known),
    )
    assert walkable["visible_ground"].item() == pytest.approx(-math.log(0.75) / 4, abs=1e-6)
    not_walkable = losses(raw_with(0, logits), with_targets(1, 2, 2, visible_ground_valid=known))
    assert not_walkable["visible_ground"].item() == pytest.approx(-math.log(0.25) / 4, abs=1e-6)


def test_ground_weighs_its_three_pixel_sets():
    logits = torch.full((1, 3), math.log(3))  # probability 0.75
    found = losses(
        raw_with(1, logits),
        with_targets(
            1,
            1,
            3,
            ground=[[[1, 0, 0]]],
            untraversable=[[[0, 1, 0]]],
            unknown_weight=[[[1, 1, 0.25]]],
        ),
    )
    expected = (-math.log(0.75) - math.log(0.25) - 0.25 * math.log(0.25)) / 3
    assert found["ground"].item() == pytest.approx(expected, abs=1e-6)


def test_a_footprint_counts_three_times_and_leaves_no_room_for_the_prior():
    logits = torch.full((1, 2), math.log(3))  # probability 0.75
    targets = with_targets(1, 1, 2, untraversable=[[[1, 3]]], unknown_weight=[[[0.25, 0.25]]])
    found = losses(raw_with(1, logits), targets)["ground"]
    assert found.item() == pytest.approx(-4 * math.log(0.25) / 2, abs=1e-6)


def test_the_moving_mask_silences_decided_pixels_and_not_the_prior():
    logits = torch.full((1, 3), math.log(3))
    raw = raw_with(1, logits).requires_grad_()
    targets = with_targets(
        1,
        1,
        3,
        ground=[[[1, 0, 0]]],
        untraversable=[[[0, 1, 0]]],
        unknown_weight=[[[0.25, 0.25, 0.25]]],
        moving=[[[1, 1, 1]]],
    )
    found = losses(raw, targets)["ground"]
    assert found.item() == pytest.approx(-0.25 * math.log(0.25) / 3, abs=1e-6)
    found.backward()
    assert (raw.grad[0, 1, 0] != 0).tolist() == [False, False, True]


@pytest.mark.parametrize("channel", [2, 3])
def test_depth_loss_is_the_log_of_the_error_in_metres(channel):
    name = {2: "visible_depth", 3: "ground_depth"}[channel]
    disparity = torch.tensor([[(1 / 2 - 0.01) / 9.99, 0.3]])  # 2 m, and one nobody asks for
    targets = with_targets(1, 1, 2, **{f"{name}_m": [[[5.0, 0.0]]]})
    found = losses(raw_with(channel, disparity), targets)
    assert found[name].item() == pytest.approx(math.log(4) / 2, abs=1e-5)
    other = {2: "ground_depth", 3: "visible_depth"}[channel]
    assert found[other].item() == 0


def test_multiscale_losses_are_means_over_scales():
    targets = with_targets(1, 4, 4, visible_ground_valid=torch.ones(1, 4, 4))
    low, high = torch.full((1, 4, 4, 4), -1.0), torch.full((1, 4, 4, 4), 2.0)
    scales = {"1/1": low, "1/2": high, "1/4": high, "1/8": high}
    found = multiscale_losses(scales, targets)["loss"].item()
    soft = [math.log1p(math.exp(value)) for value in (-1, 2, 2, 2)]  # the loss of a "no"
    assert found == pytest.approx(sum(soft) / 4, abs=1e-5)


def test_relative_depth_is_a_ratio_wherever_it_is_and_what_a_picture_is_too_far():
    """Twice too far on one of two known pixels, half too far on the other; a third is unknown."""
    target_m = torch.tensor([[[2.0, 20.0, 0.0]]])
    for factors, mean in (((2.0, 2.0), math.log(2)), ((2.0, 0.5), 0.0)):
        disparity = depth_to_disparity(torch.tensor([[[2 * factors[0], 20 * factors[1], 9.0]]]))
        found = relative_depth_loss(disparity, target_m).item()
        assert found == pytest.approx(2 * math.log(2) / 3 + mean, rel=1e-4)
    assert relative_depth_loss(disparity, torch.zeros(1, 1, 3)).item() == 0


def test_dice_is_that_of_probabilities_on_what_is_known():
    logit = torch.tensor([[[math.log(3), -math.log(3), 50.0]]])  # 0.75, 0.25, 1
    true, known = torch.tensor([[[1.0, 0.0, 0.0]]]), torch.tensor([[[1.0, 1.0, 0.0]]])
    expected = 1 - (2 * 0.75 + 1) / (1.0 + 1.0 + 1)
    assert dice_loss(logit, true, known).item() == pytest.approx(expected, rel=1e-5)
    assert dice_loss(logit, true, 0 * known).item() == 0


def test_classes_in_balance_weigh_as_much_as_visible_ground():
    targets = with_targets(
        1,
        1,
        8,
        ground=[[[1, 1, 1, 1, 1, 0, 0, 0]]],
        visible_ground=[[[1, 1, 1, 1, 0, 0, 0, 0]]],
        visible_ground_valid=torch.ones(1, 1, 8),
        untraversable=[[[0, 0, 0, 0, 0, 3, 1, 1]]],
    )
    factors = class_balance(targets) * ground_weights(targets)
    assert factors.flatten().tolist() == pytest.approx([1, 1, 1, 1, 4, 4, 1, 1])
    no_ground = with_targets(1, 1, 1, untraversable=[[[3]]], visible_ground_valid=[[[1]]])
    assert class_balance(no_ground).item() == 1


@pytest.mark.parametrize(("true", "wrong"), [(1.0, 0.25), (0.0, 0.75)])
def test_the_focal_factor_is_the_square_of_what_is_missing(true, wrong):
    logit = torch.full((1, 1, 1), math.log(3))  # 0.75
    targets = with_targets(1, 1, 1, ground=[[[true]]])
    assert focal_factor(logit, targets).item() == pytest.approx(3 * wrong**2, rel=1e-5)
