"""Matterport's ground truth."""

import numpy as np
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.ground_truth.datasets import (
    ReadingOptions,
    Subset,
    open_folder,
)

ALL = Subset()


def loaded(dataset):
    return {item.name: item.load() for item in dataset.items}


def test_ground_truth_is_what_the_files_say(matterport, tmp_path):
    folder, raw = matterport
    (dataset,) = open_folder(folder, ReadingOptions(images=tmp_path / "raw"), ALL)
    assert dataset.kind == "Matterport"
    ((name, ground_truth),) = loaded(dataset).items()
    assert name == "truth/scan1_abc_1_4"
    assert ground_truth.image == raw / "matterport_color_images" / "abc_i1_4.jpg"
    assert ground_truth.intrinsics == Intrinsics(150.5, 151.5, 80.5, 62.5)
    rows = np.mgrid[:64, :80][0]
    np.testing.assert_array_equal(ground_truth.ground.mask, rows >= 32)
    np.testing.assert_array_equal(ground_truth.ground_depth_m, np.where(rows >= 32, 2, 0))
    np.testing.assert_array_equal(ground_truth.region, rows >= 40)
    assert ground_truth.visible_ground is None and ground_truth.visible_depth_m is None


def test_matterport_s_measured_depth_shows_what_is_visible(matterport, tmp_path):
    folder, raw = matterport
    depth_m = np.full((128, 160), 2.0)
    depth_m[:, :80] = 1.0  # in front of the floor
    depth_m[:, 150:] = 0  # not measured
    (raw / "matterport_depth_images").mkdir()
    units = (depth_m / 0.00025).astype(np.uint16)
    Image.fromarray(units).save(raw / "matterport_depth_images" / "abc_d1_4.png")
    (ground_truth,) = loaded(
        open_folder(folder, ReadingOptions(images=tmp_path / "raw"), ALL)[0]
    ).values()
    rows, columns = np.mgrid[:64, :80]
    expected = (rows >= 32) & (columns >= 40) & (columns < 75)
    np.testing.assert_array_equal(ground_truth.visible_ground.mask, expected)
    np.testing.assert_array_equal(ground_truth.visible_ground.valid, columns < 75)
    np.testing.assert_allclose(ground_truth.visible_depth_m[0], np.repeat([1, 2, 0], [40, 35, 5]))
