"""The learner: its average, and the way back after a bad step."""

import pytest
import torch

from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.training.batches import stack
from footprints_edge_models.training.gpu_kit.learner import Learner
from footprints_edge_models.training.recipe import Recipe

CPU = torch.device("cpu")


@pytest.fixture
def recipe(tmp_path):
    torch.manual_seed(0)
    torch.save(EdgeNetwork().state_dict(), tmp_path / "initial.pt")
    return Recipe((), batch=2, init=str(tmp_path / "initial.pt"), ema_decay=0.5)


@pytest.fixture
def batch(sample):
    views = [render_view(sample(seed), (32, 64), focal_px=70.0) for seed in range(2)]
    image, targets = stack(views)
    return image / 255, targets


def weights(network):
    return {name: tensor.clone() for name, tensor in network.state_dict().items()}


def head(network):
    return network.head.weight.detach().clone()


def test_steps_lower_the_loss(recipe, batch):
    learner = Learner(recipe, CPU)
    losses = [learner.step(batch, 1.0)["loss"].item() for _ in range(8)]
    assert losses[-1] < 0.9 * losses[0]


def test_the_average_follows_the_weights(recipe, batch):
    learner = Learner(recipe, CPU)
    learner.lay_out(torch.contiguous_format)
    learner.lay_out(torch.channels_last)
    mean = head(learner.network)
    for step in range(3):
        learner.step(batch, 1.0)
        mean = mean.lerp(head(learner.network), 1 - min(0.5, (1 + step) / (10 + step)))
    assert torch.allclose(head(learner.average), mean, atol=1e-7)
    assert not torch.allclose(mean, head(learner.network), atol=1e-5)


def test_a_bad_step_is_undone(recipe, batch):
    learner = Learner(recipe, CPU)
    learner.step(batch, 1.0)
    learner.keep()
    good, good_average = weights(learner.network), weights(learner.average)
    image, targets = batch
    learner.step((image * torch.nan, targets), 1.0)
    assert not head(learner.network).isfinite().all()
    learner.go_back()
    for network, state in ((learner.network, good), (learner.average, good_average)):
        assert all(torch.equal(now, state[name]) for name, now in network.state_dict().items())
    assert learner.step(batch, 1.0)["loss"].isfinite()
