"""The mean of weights."""

import numpy as np
import pytest
import torch

from footprints_edge.errors import ModelError
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.networks.registry import NETWORKS
from footprints_edge_models.training.averaging import mean_of
from footprints_edge_models.training.run_files import save_weights

CHAIR = Credit("Chair", "A. Maker", "CC-BY-3.0", "https://example.org/chairs")
CITY = Credit("A city", "B. Planner", "CC0-1.0", "https://example.org/city")


def weights(path, number, *, coarse=True, focal_px=400.0, credits=()):
    torch.manual_seed(number)
    network = EdgeNetwork(coarse_decoder=coarse)
    save_weights(network, focal_px, path, credits)
    return network.state_dict()


def test_every_weight_is_the_mean_and_all_are_credited(tmp_path):
    files = [tmp_path / f"{number}.pt" for number in range(3)]
    states = [
        weights(file, number, credits=credits)
        for number, (file, credits) in enumerate(
            zip(files, ([CHAIR], [], [CITY, CHAIR]), strict=True)
        )
    ]
    network, focal_px, credits = mean_of(files, NETWORKS["edge"])
    assert focal_px == 400
    assert set(credits) == {CHAIR, CITY}
    mean = network.state_dict()
    assert set(mean) == set(states[0])
    for name, tensor in mean.items():
        expected = np.mean([state[name].double().numpy() for state in states], axis=0)
        # the files are in half precision
        np.testing.assert_allclose(tensor.numpy(), expected, rtol=1e-3, atol=1e-4, err_msg=name)


@pytest.mark.parametrize(
    ("other", "says"), [({"coarse": False}, "missing"), ({"focal_px": 500.0}, "500.0")]
)
def test_weights_that_do_not_belong_together_are_refused(tmp_path, other, says):
    weights(tmp_path / "a.pt", 1)
    weights(tmp_path / "b.pt", 2, **other)
    with pytest.raises(ModelError, match=says) as caught:
        mean_of([tmp_path / "a.pt", tmp_path / "b.pt"], NETWORKS["edge"])
    assert "b.pt" in str(caught.value)
