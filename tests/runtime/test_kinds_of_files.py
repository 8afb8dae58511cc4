"""Every format, and every use of a prediction, on every kind of model file."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from predictions import make_prediction

import footprints_edge as fp
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.ground_maps import MAPS
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.outputs.writers import FORMATS

SIZE = (64, 96)
LACKING = {
    "all": (),
    "masks": ("visible_depth_m", "unmasked_ground_depth_m"),
    "depths": ("visible_ground_probability", "ground_probability"),
}
NEEDS = {"overlay": "both", "npz": "", "png16": "", "json": "", "ply": "both"}
"""What a format needs; the others need a ground plane, and so both kinds of maps."""


@pytest.fixture(params=LACKING)
def kind(request):
    """A kind of model file, by its key `outputs`."""
    return request.param


@pytest.fixture
def prediction(kind):
    """What such a file predicts: a floor, seen in the lower half."""
    rows = np.arange(64)[:, None] + np.zeros(96)
    depth_m = 40 / np.maximum(rows - 20, 1)
    whole = make_prediction(depth_m, ground=rows >= 32, picture=np.zeros((*SIZE, 3), np.uint8))
    maps = {
        field.name: getattr(whole.maps, field.name) for field in dataclasses.fields(DecodedMaps)
    }
    maps |= dict.fromkeys(LACKING[kind])
    return dataclasses.replace(whole, maps=DecodedMaps(**maps))


@pytest.mark.parametrize("name", FORMATS)
def test_a_format_is_written_or_says_what_is_missing(name, kind, prediction, tmp_path):
    possible = kind == "all" or NEEDS.get(name, "both") == ""
    if possible:
        assert prediction.save(tmp_path, [name])
    else:
        with pytest.raises(fp.MissingMapError, match=kind):
            prediction.save(tmp_path, [name])
    assert bool(list(tmp_path.iterdir())) == possible


def test_it_can_be_shown_compared_and_copied(kind, prediction):
    assert "\n" not in repr(prediction) and len(repr(prediction)) < 300
    for again in (
        copy.copy(prediction),
        copy.deepcopy(prediction),
        pickle.loads(pickle.dumps(prediction)),
        dataclasses.replace(prediction, threshold=0.4),
    ):
        assert again.has("ground_probability") == (kind != "depths")
        assert hasattr(again, "ground_probability") == (kind != "depths")
        assert hasattr(again, "visible_depth_m") == (kind != "masks")
        assert again.map_size == SIZE
    assert prediction.at_size((32, 48)).map_size == (32, 48)
    assert summarise(prediction)["map_size_px"] == list(SIZE)


def test_it_can_be_smoothed(kind, prediction):
    pytest.importorskip("cv2")
    tracker = fp.Tracker()
    for _ in range(2):
        smoothed = tracker.update(prediction)
    assert [smoothed.has(name) for name in MAPS] == [name not in LACKING[kind] for name in MAPS]
