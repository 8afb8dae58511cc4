"""Photos that a segmenter labels, read again as a dataset."""

import numpy as np
import pytest
from PIL import Image

from footprints_edge.errors import ImageError
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.photo_labels import label_photos
from footprints_edge_models.data.readers.labelled_photos import ADE20K, read_photos
from footprints_edge_models.sample import YES

WALL, FLOOR = 1, 4


def floor_below(image):
    """A segmenter: the lower half of any picture is floor."""
    assert image.dtype == np.uint8
    ids = np.full((64, 64), WALL, np.uint8)
    ids[32:] = FLOOR
    return ids


def photo(path, size_wh, *, coloured=True):
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (size_wh[1], size_wh[0], 3), np.uint8)
    Image.fromarray(noise if coloured else noise[..., :1].repeat(3, axis=2)).save(path)


def test_labelled_photos_are_a_dataset_and_the_others_are_named(tmp_path):
    given, made = tmp_path / "given", tmp_path / "made"
    given.mkdir()
    photo(given / "hall.jpg", (1600, 1200))
    photo(given / "hall.png", (400, 400))
    photo(given / "narrow.png", (800, 200))
    photo(given / "old.png", (400, 400), coloured=False)
    (given / "torn.jpg").write_bytes(b"\xff\xd8\xff torn")
    done, twin, narrow, old, torn = label_photos(given, made, floor_below)  # by their names
    assert done is None
    assert "hall.png" in twin and "of this name" in twin
    assert "narrow.png" in narrow and "too narrow" in narrow
    assert "old.png" in old and "black and white" in old
    assert isinstance(torn, ImageError) and "torn.jpg" in str(torn)
    assert sorted(file.name for file in made.rglob("*.*")) == ["hall.jpg", "hall.png"]
    assert Image.open(made / "images" / "hall.jpg").size == (640, 480)
    (sample,) = read_photos(made, ADE20K)
    seen = sample.visible_ground == YES
    assert seen[len(seen) // 2 + 2 :].all()
    assert not seen[: len(seen) // 2 - 2].any()


def test_an_interrupted_folder_is_continued(tmp_path):
    given, made = tmp_path / "given", tmp_path / "made"
    given.mkdir()
    photo(given / "hall.jpg", (640, 480))
    assert list(label_photos(given, made, floor_below)) == [None]
    before = {file: file.read_bytes() for file in made.rglob("*.*")}
    assert list(label_photos(given, made, None)) == [None]  # nothing is segmented again
    assert {file: file.read_bytes() for file in made.rglob("*.*")} == before


def test_a_folder_without_photos_is_an_error(tmp_path):
    with pytest.raises(DatasetError, match="no photos"):
        list(label_photos(tmp_path, tmp_path / "made", floor_below))
