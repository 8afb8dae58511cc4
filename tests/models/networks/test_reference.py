"""The paper's network: its layout and its numbers, against those of the published one."""

import numpy as np
import pytest
import torch

from footprints_edge_models.networks.channels import raw_to_maps
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.reference import SCALES, ReferenceNetwork


@pytest.fixture(scope="module")
def network(reference_checkpoint):
    network = ReferenceNetwork().eval()
    load_weights(network, read_checkpoint(reference_checkpoint), str(reference_checkpoint))
    return network


@pytest.fixture(scope="module")
def image(reference_fixture):
    return torch.from_numpy(reference_fixture["image"]).permute(2, 0, 1)[None].float() / 255


def test_as_many_tensors_and_elements_as_the_published_checkpoints():
    tensors = ReferenceNetwork().state_dict().values()
    assert len(tensors) == 484
    assert sum(tensor.numel() for tensor in tensors) == 31_046_936


def test_keys_and_shapes_in_the_published_order(reference_layout):
    found = [(k, tuple(v.shape)) for k, v in ReferenceNetwork().state_dict().items()]
    assert found == reference_layout


@torch.no_grad()
def test_the_maps_are_those_of_the_published_network(network, image, reference_fixture):
    maps = raw_to_maps(network(image)).numpy()
    assert maps.shape == (1, 4, 96, 128)
    np.testing.assert_allclose(maps, reference_fixture["maps"], rtol=0, atol=1e-5)


@torch.no_grad()
def test_every_scale_is_that_of_the_published_network(network, image, reference_fixture):
    scales = network.scales(image)
    assert set(scales) == set(SCALES)
    for scale, raw in scales.items():
        stored = reference_fixture[f"raw_scale_{scale.replace('/', '_')}"]
        # Side outputs are stored in half precision, whose rounding is up to half a step.
        step = np.spacing(np.abs(stored)).astype(np.float32)
        allowed = 1e-5 + (step / 2 if stored.dtype == np.float16 else 0)
        assert (np.abs(raw.numpy() - stored.astype(np.float32)) <= allowed).all(), scale


@torch.no_grad()
def test_portrait_and_landscape_keep_their_size():
    network = ReferenceNetwork().eval()
    for height, width in ((96, 64), (64, 128)):
        assert network(torch.rand(2, 3, height, width)).shape == (2, 4, height, width)
