import json

import numpy as np
import pytest
from PIL import Image

from footprints_edge_bench.ground_truth.base import GroundTruthError
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset, open_folder


def rectangle(x0, y0, x1, y1):
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]


@pytest.fixture
def folder(tmp_path):
    """Two photos of 20 x 10 pixels: ground below y = 4, a thing on it, half of it seen."""
    root = tmp_path / "hand"
    (root / "images").mkdir(parents=True)
    photos = []
    for name, kind in (("b.jpg", "street"), ("a.jpg", "indoor"), ("c.jpg", "street")):
        Image.new("RGB", (20, 10)).save(root / "images" / name)
        photos.append(
            {
                "name": name,
                "kind": kind,
                "size_wh": [20, 10],
                "ground": [rectangle(0, 4, 20, 10)],
                "footprints": [rectangle(8, 6, 12, 8)],
                "visible": [rectangle(0, 4, 10, 10)],
                "ignore": [rectangle(18, 0, 20, 10)],
            }
        )
    (root / "truth.json").write_text(json.dumps(photos))
    return root


def test_each_kind_of_photo_is_a_dataset_of_its_own(folder):
    found = open_folder(folder, ReadingOptions(), Subset())
    assert {each.name: [item.name for item in each.items] for each in found} == {
        "hand-indoor": ["hand-indoor/a.jpg"],
        "hand-street": ["hand-street/b.jpg", "hand-street/c.jpg"],
    }
    assert {each.kind for each in found} == {"hand-drawn ground"}


def test_polygons_become_masks(folder):
    (indoor, _) = open_folder(folder, ReadingOptions(), Subset())
    found = indoor.items[0].load()
    assert found.size == (10, 20)
    y, x = np.mgrid[:10, :20]
    below, thing, seen, ignored = y >= 4, (x >= 8) & (x < 12) & (y >= 6) & (y < 8), x < 10, x >= 18
    np.testing.assert_array_equal(found.ground.mask, below & ~thing & ~ignored)
    np.testing.assert_array_equal(found.ground.valid, ~ignored)
    np.testing.assert_array_equal(found.visible_ground.mask, below & seen & ~thing & ~ignored)
    np.testing.assert_array_equal(found.region, below & ~ignored)


def test_damaged_annotations_and_missing_photos_are_named(folder):
    (folder / "images" / "a.jpg").unlink()
    (indoor, _) = open_folder(folder, ReadingOptions(), Subset())
    with pytest.raises(GroundTruthError, match=r"a\.jpg: no such image"):
        indoor.items[0].load()
    (folder / "truth.json").write_text('{"photos": 1}')
    with pytest.raises(GroundTruthError, match=r"truth\.json is not a list"):
        open_folder(folder, ReadingOptions(), Subset())
