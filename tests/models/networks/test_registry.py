"""Every registered network has what training and export ask of one."""

import pytest
import torch

from footprints_edge_export.architectures import ARCHITECTURES
from footprints_edge_models.networks.registry import NETWORKS


@torch.no_grad()
@pytest.mark.parametrize("name", NETWORKS)
def test_a_network_gives_raw_channels_from_an_encoder_of_its_own(name):
    network = NETWORKS[name].build().eval()
    image = torch.rand(1, 3, 64, 96)
    raw = network(image)
    assert raw.shape == (1, 4, 64, 96)
    torch.testing.assert_close(network.scales(image)["1/1"], raw)
    assert ((raw[:, 2:] >= -1e-6) & (raw[:, 2:] <= 1 + 1e-6)).all()  # disparities
    trained = [key for key, _ in network.named_parameters() if key.startswith("encoder.")]
    assert 0 < len(trained) < len(list(network.parameters()))


def test_every_network_can_be_exported():
    assert ARCHITECTURES.keys() == NETWORKS.keys()
