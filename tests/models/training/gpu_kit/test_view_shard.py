"""Shards: small, and near enough to what went in."""

import zipfile

import numpy as np
import pytest

from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.training.gpu_kit.stored_view import stored_view
from footprints_edge_models.training.gpu_kit.view_shard import ShardView, read_shard, write_shard


def test_views_come_back_labels_exactly_depths_within_half_a_step(sample, tmp_path):
    views = [
        ShardView(stored_view(sample(0), 9000), "photos", "train"),
        ShardView(stored_view(sample(1, (80, 48)), 9000), "office", "held out"),
    ]
    taken = write_shard(tmp_path / "views.zip", views)
    assert set(taken) == {"photos", "office"}
    assert sum(taken.values()) < (tmp_path / "views.zip").stat().st_size < 60_000
    back = read_shard(tmp_path / "views.zip")
    for one, other in zip(views, back, strict=True):
        assert (other.dataset, other.split) == (one.dataset, one.split)
        assert other.view.intrinsics == one.view.intrinsics
        assert np.array_equal(other.view.pixels[..., 3], one.view.pixels[..., 3])
        change = other.view.pixels.astype(int) - one.view.pixels
        assert np.abs(change).mean() < 3
        depth_m = one.view.depths_m.astype(float)
        assert np.array_equal(other.view.depths_m > 0, depth_m > 0)
        ratio = (other.view.depths_m / np.where(depth_m > 0, depth_m, 1))[depth_m > 0]
        assert np.abs(ratio - 1).max() < 0.004


@pytest.mark.parametrize("content", [b"", b"no zip at all"])
def test_a_damaged_shard_is_named(content, tmp_path):
    (tmp_path / "views.zip").write_bytes(content)
    with pytest.raises(DatasetError, match=r"views\.zip"):
        read_shard(tmp_path / "views.zip")


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("000000.jpg", b"no picture"),
        ("000000.png", b""),
        ("views.json", b"{}"),
        ("views.json", b'[["photos", "train", "x", 1, 1, 1]]'),
        ("views.json", b'[["photos", "train", NaN, 1, 1, 1]]'),
        ("views.json", b'[["photos", "test", 9, 9, 1, 1]]'),
        ("views.json", b"[7]"),
    ],
)
def test_a_shard_with_a_damaged_file_is_named(sample, tmp_path, name, data):
    path = tmp_path / "views.zip"
    write_shard(path, [ShardView(stored_view(sample(0), 9000), "photos", "train")])
    with zipfile.ZipFile(path) as archive:
        files = {each: archive.read(each) for each in archive.namelist()} | {name: data}
    with zipfile.ZipFile(path, "w") as archive:
        for each, content in files.items():
            archive.writestr(each, content)
    with pytest.raises(DatasetError, match=r"views\.zip: no readable views"):
        read_shard(path)
