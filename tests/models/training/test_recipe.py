"""Recipes: schedules, learning rates, and the switches of the loss."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
import torch

from footprints_edge_models.data.targets import Targets
from footprints_edge_models.training.losses import ground_loss
from footprints_edge_models.training.recipe import (
    Recipe,
    resumed_recipe,
    switched,
)
from footprints_edge_models.training.schedule import ScheduleStage, TrainingError, size_at


def test_a_stage_is_read_from_text():
    assert ScheduleStage.parse("192x320:1800") == ScheduleStage((192, 320), 1800)
    assert ScheduleStage.parse("32X64:1") == ScheduleStage((32, 64), 1)


@pytest.mark.parametrize(
    "text",
    [
        *("", "192x320", "192:320:10", "192x320:x", "ax320:5", "100x320:5", "192x320:0"),
        *("0x320:5", "-32x64:5", "192x320x64:5", "192x320:-1", "192x320:1.5"),
    ],
)
def test_a_stage_that_is_none_is_named(text):
    with pytest.raises(TrainingError) as caught:
        ScheduleStage.parse(text)
    assert repr(text) in str(caught.value)


def factors(recipe, steps=100):
    return [recipe.lr_factor(step, recipe.decayed(step)) for step in range(steps)]


def test_the_rate_warms_up_stays_and_falls_to_nothing():
    rates = factors(Recipe((ScheduleStage((32, 32), 100),), warmup_steps=10, decay=0.2))
    assert rates[0] == pytest.approx(0.1)
    assert np.diff(rates[:10]).min() > 0
    assert rates[9:81] == pytest.approx([1] * 72)
    assert np.diff(rates[80:]).max() < 0
    assert rates[90] == pytest.approx(0.5)
    assert 0 < rates[-1] < 0.01


def test_a_decay_of_the_whole_run_is_the_usual_cosine():
    rates = factors(Recipe((ScheduleStage((32, 32), 100),), warmup_steps=10, decay=1.0))
    assert rates[:10] == pytest.approx([0.1 * (step + 1) for step in range(10)])
    for step in range(10, 100):
        assert rates[step] == pytest.approx(0.5 * (1 + math.cos(math.pi * (step - 10) / 90)))


def test_a_run_that_is_given_minutes_decays_at_their_end():
    recipe = Recipe((ScheduleStage((32, 32), 1),), minutes=10, decay=0.2, warmup_steps=1)
    assert [recipe.decayed(9, share) for share in (0, 0.5, 0.8)] == pytest.approx([0, 0, 0])
    assert recipe.decayed(9, 0.9) == pytest.approx(0.5)
    assert recipe.decayed(9, 1.01) == 1


def test_a_decay_from_another_run_warms_nothing_up():
    recipe = Recipe((ScheduleStage((32, 32), 100),), decay_from="run", decay=1.0)
    assert factors(recipe)[0] == 1
    assert factors(recipe)[50] == pytest.approx(0.5)


def test_the_last_stage_goes_on_beyond_its_steps():
    stages = (ScheduleStage((32, 32), 2), ScheduleStage((64, 96), 1))
    found = [size_at(stages, step) for step in (0, 1, 2, 3, 99)]
    assert found == [(32, 32), (32, 32), (64, 96), (64, 96), (64, 96)]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"decay": 0.0}, "decay 0"),
        ({"minutes": -1.0}, "minutes -1"),
        ({"dice": math.nan}, "dice nan"),
        ({"balance": "classes", "footprint_weight": 1.0}, "above 1"),
        ({"balance": "much"}, "none, classes, focal"),
        ({"frozen_stages": 8}, "edge has 7"),
        ({"coarse_decoder": True, "network": "reference"}, "reference has none"),
        ({"frozen_stages": 1, "network": "reference"}, "reference has 0"),
        ({"decay_from": "run", "init": "weights.pt"}, "one of them"),
    ],
)
def test_what_makes_no_sense_is_refused(change, says):
    with pytest.raises(TrainingError, match=says):
        Recipe((ScheduleStage((32, 32), 1),), **change)


HIDDEN = {"visible_ground": 0.0, "visible_ground_valid": 1.0}
SEEN = {"visible_ground": 1.0, "visible_ground_valid": 1.0}


def one_pixel(**known):
    zero = torch.zeros(1, 1, 1)
    fields = dict.fromkeys(Targets.__dataclass_fields__, zero)
    known = {"ground_weight": known.get("ground", 0.0)} | known
    return Targets(**(fields | {name: torch.full((1, 1, 1), v) for name, v in known.items()}))


@pytest.mark.parametrize(
    ("switch", "known", "probability", "expected"),
    [
        # eq. 3a, 3b and 3c on one pixel of probability 0.8, each as published and switched
        ({}, {"untraversable": 1.0}, 0.8, -math.log(0.2)),
        ({"footprint_masks": False}, {"untraversable": 1.0}, 0.8, -0.25 * math.log(0.2)),
        ({"footprint_masks": False}, {"untraversable": 3.0}, 0.8, -0.25 * math.log(0.2)),
        ({}, {"unknown_weight": 0.25}, 0.8, -0.25 * math.log(0.2)),
        ({"lambda_unknown": 0.0}, {"unknown_weight": 0.25}, 0.8, 0.0),
        ({"lambda_unknown": 1.0}, {"unknown_weight": 0.25}, 0.8, -math.log(0.2)),
        (
            {"lambda_unknown": 0.5, "footprint_masks": False},
            {"untraversable": 1.0},
            0.8,
            -0.5 * math.log(0.2),
        ),
        ({}, {"ground": 1.0, "moving": 1.0}, 0.8, 0.0),
        ({"moving_objects": False}, {"ground": 1.0, "moving": 1.0}, 0.8, -math.log(0.8)),
        # ground that is known to be hidden; that is seen; of which nobody knows whether it is seen
        ({"hidden_weight": 5.0}, {"ground": 1.0, **HIDDEN}, 0.8, -5 * math.log(0.8)),
        ({"hidden_weight": 5.0}, {"ground": 1.0, **SEEN}, 0.8, -math.log(0.8)),
        ({"hidden_weight": 5.0}, {"ground": 1.0}, 0.8, -math.log(0.8)),
        ({"hidden_weight": 5.0}, {"untraversable": 1.0, **HIDDEN}, 0.8, -math.log(0.2)),
        # a footprint; another pixel that is known not to be ground
        ({"footprint_weight": 5.0}, {"untraversable": 3.0}, 0.8, -5 * math.log(0.2)),
        ({"footprint_weight": 5.0}, {"untraversable": 1.0}, 0.8, -math.log(0.2)),
    ],
)
def test_the_papers_ablations_are_switches(switch, known, probability, expected):
    recipe = Recipe((ScheduleStage((32, 32), 1),), **switch)
    logit = torch.full((1, 1, 1), math.log(probability / (1 - probability)))
    loss = ground_loss(logit, switched(one_pixel(**known), recipe))
    assert loss.item() == pytest.approx(expected, abs=1e-6)


def test_the_scale_lowers_every_learning_rate():
    stages = (ScheduleStage((32, 32), 100),)
    usual, lower = Recipe(stages), Recipe(stages, lr_scale=0.25)
    assert factors(lower) == pytest.approx([rate / 4 for rate in factors(usual)])
    with pytest.raises(TrainingError, match="scale 0"):
        Recipe(stages, lr_scale=0.0)


def test_lambda_is_a_share():
    with pytest.raises(TrainingError, match="between 0 and 1"):
        Recipe((ScheduleStage((32, 32), 1),), lambda_unknown=1.5)


@pytest.mark.parametrize("field", ["hidden_weight", "footprint_weight"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_weights_that_are_none_are_refused(field, value):
    with pytest.raises(TrainingError, match=field.replace("_", " ")):
        Recipe((ScheduleStage((32, 32), 1),), **{field: value})


def test_a_run_begun_by_an_earlier_version_goes_on_as_it_began():
    recipe = Recipe((ScheduleStage((32, 32), 1),))
    new = ("decay", "minutes", "decay_from", "balance", "relative_depth", "dice", "frozen_stages")
    stored = asdict(recipe)
    for name in (*new, "former_focal", "hidden_weight", "footprint_weight", "network"):
        del stored[name]
    as_it_began = replace(recipe, decay=1.0, former_focal=True)
    assert resumed_recipe(stored, recipe) == as_it_began
    assert resumed_recipe(asdict(as_it_began), recipe) == as_it_began  # and once more
    for change in ({"hidden_weight": 5.0}, {"decay": 0.5}, {"minutes": 5.0}, {"batch": 3}):
        assert resumed_recipe(stored, replace(recipe, **change)) is None
    assert resumed_recipe(asdict(recipe), recipe) == recipe
