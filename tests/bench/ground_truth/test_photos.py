"""Ground truth of labelled photos."""

import numpy as np
import pytest
from PIL import Image

from footprints_edge_bench.ground_truth.base import GroundTruthError
from footprints_edge_bench.ground_truth.datasets import (
    ReadingOptions,
    Subset,
    open_folder,
)

SIZE = (120, 160)

ALL = Subset()


def save_picture(path, size=SIZE):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((*size, 3), 90, np.uint8)).save(path)


def test_labelled_photos_say_what_is_visible(tmp_path):
    folder = tmp_path / "photos"
    save_picture(folder / "images" / "a.jpg")
    (folder / "labels").mkdir()
    ids = np.full(SIZE, 7, np.uint8)
    ids[40:, :50], ids[40:, 50:90], ids[40:, 90:] = 3, 4, 11
    Image.fromarray(ids).save(folder / "labels" / "a.png")
    (dataset,) = open_folder(folder, ReadingOptions(walkable=(3, 4), void=(11,)), ALL)
    ground_truth = dataset.items[0].load()
    np.testing.assert_array_equal(ground_truth.visible_ground.mask, (ids == 3) | (ids == 4))
    np.testing.assert_array_equal(ground_truth.visible_ground.valid, ids != 11)
    assert ground_truth.ground is None and ground_truth.region is None
    with pytest.raises(GroundTruthError, match="--walkable"):
        open_folder(folder, ReadingOptions(), ALL)
