import math

import numpy as np
import pytest

from footprints_edge.maps.confidence import METRES_INPUTS, Curve, Curves
from footprints_edge_bench.navigation.confidence import (
    MOST_REFUSED,
    ConfidenceError,
    Example,
    as_markdown,
    draw,
    fit,
    fit_curve,
    reliability,
    score,
)


def drawn(count=4000, seed=0):
    """Pictures that are right with a known probability; the second input tells nothing."""
    rng = np.random.default_rng(seed)
    useful, useless = rng.normal(size=(2, count))
    right = rng.random(count) < 1 / (1 + np.exp(-(0.5 + 2 * useful)))
    inputs = [{"useful": a, "useless": b} for a, b in zip(useful, useless, strict=True)]
    return inputs, right.tolist()


def test_the_fit_finds_the_curve_that_the_pictures_follow():
    inputs, right = drawn()
    curve = fit_curve(inputs, right, ("useful", "useless"), balanced=False)
    assert curve.offset == pytest.approx(0.5, abs=0.15)
    assert curve.weights["useful"] == pytest.approx(2, abs=0.2)
    assert 0 <= curve.weights["useless"] < 0.1
    assert reliability([curve.at(each) for each in inputs], right).error < 0.02


def test_weights_never_fall_below_zero():
    inputs, right = drawn()
    opposite = [{"useful": -each["useful"], "useless": each["useless"]} for each in inputs]
    assert fit_curve(opposite, right, ("useful", "useless")).weights["useful"] == 0


def test_pictures_of_one_kind_fit_nothing():
    with pytest.raises(ConfidenceError, match="4 of 4 pictures are right"):
        fit_curve([{"a": 1.0}] * 4, [True] * 4, ("a",))


def test_reliability_counts_what_is_right_in_bins_of_like_confidence():
    found = reliability([0.1] * 10 + [0.9] * 10, [True] + [False] * 9 + [True] * 8 + [False] * 2)
    assert found.count == 20
    assert found.said[0] == pytest.approx(0.1) and found.right[-1] == pytest.approx(0.5, abs=0.51)
    assert np.mean(found.right) == pytest.approx(9 / 20, abs=0.05)
    assert math.isnan(reliability([], []).error)


def test_a_balanced_reliability_counts_right_and_wrong_as_equally_frequent():
    """One bin of five holds the right picture: 9 / 10 of its weight, which is 5 / 9 of all."""
    said, right = [0.5] * 10, [True] + [False] * 9
    assert reliability(said, right).error == pytest.approx(0.4)
    found = reliability(said, right, balanced=True)
    assert found.right == pytest.approx((0.9, 0, 0, 0, 0))
    assert found.error == pytest.approx(0.4 * 5 / 9 + 0.5 * 4 / 9)


def examples():
    rng = np.random.default_rng(1)
    metres = ("flatness", "agreement", "evenness", "area", "steepness")
    for index in range(400):
        shows = index % 2 == 0
        peak = float(rng.normal(4 if shows else -1, 1))
        worth = {name: float(rng.random()) for name in metres}
        yield Example(
            "rooms" if shows else "walls",
            for_fit=index < 200,
            shows_ground=shows,
            called_ground=0.4 if shows else 0.1,
            has_plane=shows or index % 4 == 1,
            ground={"peak": peak, "clear_top": 1.0 if index % 8 != 3 else 0.1},
            ground_is_right=shows,
            metres=worth if shows else None,
            metres_are_right=bool(rng.random() < worth["flatness"]),
        )


def test_the_gate_refuses_hardly_any_ground_and_most_of_the_rest(tmp_path):
    pictures = list(examples())
    found = fit(pictures)
    scores = score(pictures, found)
    assert scores["ground"].count == 200 and scores["metres"].count == 100
    assert scores["ground"].error < 0.1
    text = as_markdown(pictures, found, scores)
    share = {
        line.split("|")[1].strip(): float(line.split("|")[4].strip(" %"))
        for line in text.splitlines()
        if "ground |" in line and "%" in line
    }
    assert share["rooms"] <= 5 and share["walls"] >= 90
    walls = next(line for line in text.splitlines() if line.startswith("| walls"))
    called, no_plane_before, no_plane = [float(each.strip(" %")) for each in walls.split("|")[5:8]]
    assert (called, no_plane_before) == (10, 50)
    assert no_plane >= 90
    draw(scores, tmp_path / "diagram.png")
    assert (tmp_path / "diagram.png").stat().st_size > 5000


def test_walls_that_look_like_ground_to_the_top_are_refused_without_refusing_floors():
    def picture(index, peak, clear_top, shows):
        return Example(
            "rooms" if shows else "walls",
            for_fit=index % 2 == 0,
            shows_ground=shows,
            called_ground=0.5,
            has_plane=True,
            ground={"peak": peak, "clear_top": clear_top},
            ground_is_right=shows,
            metres=dict.fromkeys(METRES_INPUTS, float(index % 7)) if shows else None,
            metres_are_right=index % 14 < 7,
        )

    rng = np.random.default_rng(2)
    rooms = [picture(i, float(rng.normal(4, 1)), 1.0, True) for i in range(300)]
    above = [picture(i, 6.0, 0.2, True) for i in range(20)]  # by a camera that looks down
    walls = [picture(i, float(rng.normal(3, 0.5)), 0.2, False) for i in range(100)]
    clear = [picture(i, float(rng.normal(-2, 0.5)), 1.0, False) for i in range(100)]
    found = fit([*rooms, *above, *walls, *clear])

    def refused(pictures):
        values = [found.ground.at(each.ground) for each in pictures if not each.for_fit]
        return np.mean(np.array(values) < found.least_ground)

    assert refused(walls) >= 0.95 and refused(clear) == 1
    assert refused(rooms) <= 2 * MOST_REFUSED and refused(above) == 0  # of other pictures


def test_the_file_of_curves_reads_back(monkeypatch, tmp_path):
    from footprints_edge.maps import confidence

    curves = Curves(Curve(-1.0, {"peak": 2.0}), Curve(0.5, {"area": 0.25}), 0.3)
    (tmp_path / "confidence.json").write_text(curves.to_json())
    monkeypatch.setattr(confidence, "CURVES_FILE", tmp_path / "confidence.json")
    assert confidence.curves.__wrapped__() == curves
