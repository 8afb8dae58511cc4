"""KITTI's annotations."""

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


def loaded(dataset):
    return {item.name: item.load() for item in dataset.items}


def test_ground_is_the_polygon_without_the_footprints(kitti, tmp_path):
    for number in ("00000", "00001"):
        save_picture(tmp_path / "pictures" / f"{number}.png")
    (dataset,) = open_folder(kitti, ReadingOptions(images=tmp_path / "pictures"), ALL)
    assert dataset.kind == "KITTI"
    ground_truths = loaded(dataset)
    assert list(ground_truths) == ["annotations/00000", "annotations/00001"]
    ground_truth = ground_truths["annotations/00001"]
    assert ground_truth.image == tmp_path / "pictures" / "00001.png"
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    thing = (rows >= 80) & (rows < 90) & (columns >= 50) & (columns < 70)
    np.testing.assert_array_equal(ground_truth.ground.mask, (rows >= 60) & ~thing)
    np.testing.assert_array_equal(ground_truth.region, rows >= 60)
    assert ground_truth.ground.valid.all()
    assert ground_truth.visible_ground is None and ground_truth.ground_depth_m is None
    # as the published training has KITTI's cameras
    assert ground_truth.intrinsics.fx == pytest.approx(0.58 * 160)
    assert ground_truth.intrinsics.fy == pytest.approx(1.92 * 120)


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (["a/first.jpg", "a/second.jpg"], "a/second.jpg"),
        (["d1 3 l", "d1/sync 0000000069 r"], "d1/sync/image_03/data/0000000069.jpg"),
        (["d1 3 l", "d1/sync 12 l"], "d1/sync/image_02/data/0000000012.jpg"),
    ],
    ids=["paths", "right", "left"],
)
def test_kitti_pictures_come_in_the_order_of_the_split(kitti, tmp_path, lines, expected):
    raw = tmp_path / "raw"
    save_picture(raw / expected)
    split = raw / "test_files.txt"
    split.write_text("\n".join(lines) + "\n")
    (dataset,) = open_folder(kitti, ReadingOptions(images=split), ALL)
    assert dataset.items[1].load().image == raw / expected


def test_a_split_that_is_too_short_is_said_so(kitti, tmp_path):
    split = tmp_path / "split.txt"
    split.write_text("one.jpg\n")
    (dataset,) = open_folder(kitti, ReadingOptions(images=split), ALL)
    with pytest.raises(GroundTruthError, match="lists 1 images"):
        dataset.items[1].load()
