"""Scores against the reference's, and against what they mean."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_bench.accuracy import metrics
from footprints_edge_bench.accuracy.metrics import MaskCounts

MASKS = ("iou", "precision", "recall", "f1")
DEPTHS = ("a1", "abs_rel", "sq_rel", "rmse")


@pytest.fixture(scope="module")
def evaluation(shared):
    folder = shared / "fixtures" / "reference"
    with np.load(folder / "evaluation_inputs.npz") as arrays:
        inputs = dict(arrays)
    return inputs, json.loads((folder / "evaluation_expected.json").read_text())


def same(found, expected):
    return found == pytest.approx(expected, abs=1e-9, nan_ok=True)


def test_scores_are_the_reference_s(evaluation):
    inputs, expected = evaluation
    assert len(expected) == 6
    for i, scores in expected.items():
        true, predicted = inputs[f"gt_{i}"] > 0.1, inputs[f"pred_{i}"] > 0.5
        valid = np.ones_like(true)
        freespace = metrics.freespace(predicted, true, valid)
        footprint = metrics.footprint(predicted, true, valid, inputs[f"region_{i}"])
        depth = metrics.depth(inputs[f"pred_depth_{i}"], inputs[f"gt_depth_{i}"])
        for measure in MASKS:
            assert same(getattr(freespace, measure), scores["freespace"][measure])
            assert same(getattr(footprint, measure), scores["footprint"][measure])
        for measure in DEPTHS:
            assert same(getattr(depth, measure), scores["hidden_depth"][measure])


def test_what_is_not_valid_is_not_scored(evaluation):
    inputs, expected = evaluation
    true, predicted = inputs["gt_0"] > 0.1, inputs["pred_0"] > 0.5
    wide_true = np.concatenate([true, ~true])
    wide_predicted = np.concatenate([predicted, predicted])
    valid = np.concatenate([np.ones_like(true), np.zeros_like(true)])
    region = np.concatenate([inputs["region_0"], inputs["region_0"]])
    scores = metrics.freespace(wide_predicted, wide_true, valid)
    assert same(scores.iou, expected["0"]["freespace"]["iou"])
    scores = metrics.footprint(wide_predicted, wide_true, valid, region)
    assert same(scores.f1, expected["0"]["footprint"]["f1"])


masks = st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=50)


@given(masks, masks)
def test_pooled_scores_are_those_of_one_large_image(first, second):
    def counts(pairs):
        true, predicted = np.array(pairs).T
        return metrics.freespace(predicted, true, np.ones_like(true))

    pooled, large = counts(first) + counts(second), counts(first + second)
    assert pooled == large
    if large.true:
        true, predicted = np.array(first + second).T
        union = (true | predicted).sum()
        assert large.iou == pytest.approx((true & predicted).sum() / union)
        assert 0 <= large.iou <= large.f1 <= 1
        assert large.f1 == pytest.approx(2 * large.iou / (1 + large.iou))


def test_an_empty_ground_truth_says_nothing_and_an_empty_prediction_is_all_wrong():
    assert all(math.isnan(getattr(MaskCounts(0, 7, 0), measure)) for measure in MASKS)
    assert all(getattr(MaskCounts(0, 0, 7), measure) == 0 for measure in MASKS)


def test_depths_in_closed_form():
    true_m = np.array([0, 2, 4, 0.2, 40], np.float32)
    scores = metrics.depth(np.array([9, 3, 4, np.nan, np.inf], np.float32), true_m)
    # 0: unknown. 3 for 2: off by 1. The others are right once both are clipped.
    assert scores.a1 == pytest.approx(3 / 4)
    assert scores.rmse == pytest.approx(math.sqrt(1 / 4))
    assert scores.abs_rel == pytest.approx(0.5 / 4)
    assert scores.sq_rel == pytest.approx(0.5 / 4)
