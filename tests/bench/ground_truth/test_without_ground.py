import json

import numpy as np
import pytest
from PIL import Image

from footprints_edge_bench.ground_truth.base import GroundTruthError
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset
from footprints_edge_bench.ground_truth.without_ground import largest_window, read_without_ground


def read(folder, **options):
    return read_without_ground(folder, ReadingOptions(**options), Subset())


def save(path, pixels):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(path)


@pytest.mark.parametrize("seed", range(6))
def test_a_window_has_no_ground_and_none_is_larger(seed):
    rng = np.random.default_rng(seed)
    ground = np.zeros((60, 96), bool)
    for row, column in rng.integers(0, (60, 96), (3, 2)):
        ground[row : row + 9, column : column + 9] = True
    window = largest_window(ground)
    widest = max(
        (
            columns
            for columns in range(80, 0, -8)
            for top in range(60 - columns * 3 // 4 + 1)
            for left in range(96 - columns + 1)
            if not ground[top : top + columns * 3 // 4, left : left + columns].any()
        ),
        default=0,
    )
    if widest < 0.35 * 96:
        assert window is None
    else:
        rows, columns = window
        assert not ground[rows, columns].any()
        assert columns.stop - columns.start == widest
        assert (rows.stop - rows.start) == widest * 3 // 4


def test_of_a_labelled_photo_the_part_above_all_ground_is_taken(tmp_path):
    picture = np.zeros((120, 160, 3), np.uint8)
    picture[80:] = 255
    labels = np.zeros((120, 160), np.uint8)
    labels[80:, 100:] = 4  # beside it hidden ground may be
    save(tmp_path / "images" / "room.png", picture)
    save(tmp_path / "labels" / "room.png", labels)
    (found,) = read(tmp_path, walkable=(4,))
    pixels = found.load()
    assert pixels.shape[1] / pixels.shape[0] == pytest.approx(4 / 3, rel=0.05)
    assert pixels.shape[0] > 60 and not pixels.any()


def test_textures_of_walls_and_the_upper_part_of_panoramas(tmp_path):
    panorama = np.zeros((128, 256, 3), np.uint8)
    panorama[:64, :, 2] = 250
    panorama[64:, :, 0] = 250
    save(tmp_path / "hall.png", panorama)
    save(tmp_path / "bricks.png", np.full((8, 8, 3), 7, np.uint8))
    save(tmp_path / "tiles.png", np.full((8, 8, 3), 9, np.uint8))
    index = [
        {"file": "bricks.png", "use": "wall"},
        {"file": "tiles.png", "use": "floor"},
        {"file": "hall.png", "projection": "equirectangular"},
    ]
    (tmp_path / "index.json").write_text(json.dumps(index))
    wall, *views = read(tmp_path)
    assert (wall.load() == 7).all()
    assert len(views) == 6
    assert all((view.load()[..., 0] < 20).all() for view in views)


def test_other_folders_are_taken_as_they_are_and_empty_ones_refused(tmp_path):
    with pytest.raises(GroundTruthError, match="no picture without ground"):
        read(tmp_path)
    save(tmp_path / "sky.png", np.full((8, 8, 3), 200, np.uint8))
    (found,) = read(tmp_path)
    assert found.name == f"{tmp_path.name}/sky" and (found.load() == 200).all()
    (tmp_path / "index.json").write_text("[1]")
    with pytest.raises(GroundTruthError, match="does not list textures"):
        read(tmp_path)
