"""An RGB-D clip around a crate: labels and depths in closed form."""

import json

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.rgbd_clip import read_rgbd_clip
from footprints_edge_models.sample import NO, UNKNOWN, UNSEEN, YES

CLIP_SIZE = (120, 160)
CLIP_CAMERA = Intrinsics(110.0, 110.0, 79.5, 59.5)


@pytest.fixture
def rgbd_clip(tmp_path, scene, box, pose):
    """Ten frames around a crate on a floor; y of the world points down, as gravity does."""
    folder = tmp_path / "clip"
    for name in ("images", "depth"):
        (folder / name).mkdir(parents=True)
    room = scene((box((-0.4, -0.4, 0), (0.4, 0.4, 0.5)),))
    z_up_to_y_down = np.eye(4)
    z_up_to_y_down[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    frames, depths = [], []
    for index, angle in enumerate(np.linspace(0, 2 * np.pi, 10, endpoint=False)):
        at = pose((2.2 * np.cos(angle), 2.2 * np.sin(angle), 1.5), (0, 0, 0.2))
        depth_m = room.depth_m(at, CLIP_CAMERA, CLIP_SIZE)
        depth_m[depth_m > 6] = 0
        name = f"{index:03d}"
        Image.fromarray((depth_m * 1000).astype(np.uint16)).save(folder / "depth" / f"{name}.png")
        Image.fromarray(np.full((*CLIP_SIZE, 3), 10 * index, np.uint8)).save(
            folder / "images" / f"{name}.jpg"
        )
        frames.append({"name": name, "camera_to_world": (z_up_to_y_down @ at).tolist()})
        depths.append(depth_m)
    camera = CLIP_CAMERA
    intrinsics = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (folder / "sequence.json").write_text(
        json.dumps({"intrinsics": intrinsics, "frames": frames, "gravity_direction": [0, 1, 0]})
    )
    return folder, frames, depths, z_up_to_y_down


def test_an_rgbd_clip(rgbd_clip):
    folder, frames, depths, z_up_to_y_down = rgbd_clip
    samples = list(read_rgbd_clip(folder))
    assert len(samples) == 10
    rows, columns = np.mgrid[: CLIP_SIZE[0], : CLIP_SIZE[1]].astype(float)
    x, y = (columns - 79.5) / 110, (rows - 59.5) / 110
    hidden_pixels = 0
    for sample, frame, depth_m in zip(samples, frames, depths, strict=True):
        assert sample.image.mean() == pytest.approx(10 * int(frame["name"]), abs=3)
        pose = np.linalg.inv(z_up_to_y_down) @ frame["camera_to_world"]
        rays = np.stack([x, y, np.ones_like(x)], -1) @ pose[:3, :3].T
        floor_m = np.where(rays[..., 2] < 0, -1.5 / rays[..., 2], np.inf)
        points = pose[:3, 3] + floor_m[..., None] * rays
        core = np.abs(points[..., :2]).max(axis=-1) < 0.3
        near = (np.abs(points[..., :2]).max(axis=-1) < 0.9) & ~(
            np.abs(points[..., :2]).max(axis=-1) < 0.55
        )
        seen_floor = (depth_m > 0) & (np.abs(depth_m - floor_m) < 0.01)

        np.testing.assert_allclose(sample.visible_depth_m, depth_m, rtol=2e-3, atol=2e-3)
        known = sample.visible_ground != UNKNOWN
        assert ((sample.visible_ground == YES) == seen_floor)[known].mean() > 0.97
        assert not known[depth_m == 0].any()
        # Colour and depth are a little apart: the border of the floor is nobody's.
        yes, no = sample.visible_ground == YES, sample.visible_ground == NO
        assert not (yes[:, 1:] & no[:, :-1]).any()
        assert not (yes[1:] & no[:-1]).any()

        assert (sample.ground[core] == NO).mean() > 0.97
        hidden = near & ~seen_floor & (depth_m > 0)
        hidden_pixels += hidden.sum()
        assert (sample.ground[hidden] == YES).mean() > 0.9
        assert (sample.ground[seen_floor & near] == YES).mean() > 0.97

        ground = sample.ground == YES
        np.testing.assert_allclose(sample.ground_depth_m[ground], floor_m[ground], rtol=0.02)
        assert not sample.ground_depth_m[~ground].any()
        assert set(np.unique(sample.ground)) <= {NO, YES, UNSEEN}
    assert hidden_pixels > 100


@pytest.mark.parametrize("part", ["images/003.jpg", "depth/003.png", "sequence.json"])
def test_an_rgbd_clip_that_lacks_a_part_says_which(rgbd_clip, part):
    folder, *_ = rgbd_clip
    (folder / part).unlink()
    folder.rename(folder.with_name("hololens_office"))
    with pytest.raises(DatasetError, match=r"hololens_office.*(003|sequence)"):
        load_datasets(folder.parent)


def test_the_end_of_a_clip_is_held_out_after_a_gap(rgbd_clip):
    folder, *_ = rgbd_clip
    folder.rename(folder.with_name("hololens_office"))
    datasets = load_datasets(folder.parent)
    assert list(datasets) == ["hololens_office"]
    dataset = datasets["hololens_office"]
    names = [[s.name.split("/")[1] for s in part] for part in (dataset.train, dataset.held_out)]
    assert names == [[f"{i:03d}" for i in range(7)], ["008", "009"]]
