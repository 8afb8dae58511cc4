"""The training mixture: which datasets are found, what is held out, copy-paste photos."""

import numpy as np
import pytest

from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.labelled_photos import CAMVID
from footprints_edge_models.sample import NO, UNKNOWN, YES


def walls(write_photo, folder, names):
    for name in names:
        write_photo(folder, name, np.ones((8, 8)))


def test_whole_houses_are_held_out_and_nothing_is_lost(write_photo, tmp_path):
    names = [f"{house}_{room}" for house in range(60) for room in ("bath", "kitchen")]
    walls(write_photo, tmp_path / "houses", names)
    (dataset,) = load_datasets(tmp_path).values()
    train, held_out = ({s.name.split("/")[1] for s in p} for p in (dataset.train, dataset.held_out))
    assert not train & held_out
    assert train | held_out == set(names)
    assert len(dataset.train) + len(dataset.held_out) == len(names)
    assert not {n.split("_")[0] for n in train} & {n.split("_")[0] for n in held_out}
    assert 0 < len(held_out) < len(names) / 5


def test_photos_of_streets_come_with_things_set_down_in_them_too(write_photo, tmp_path):
    ids = np.full((120, 160), 3)
    ids[:40] = 0
    write_photo(tmp_path / "camvid" / "train", "empty", ids)
    ids[50:100, 60:80] = 9
    write_photo(tmp_path / "camvid" / "train", "walker", ids)
    datasets = load_datasets(tmp_path)
    assert list(datasets) == ["camvid", "camvid copy-paste"]
    pasted = datasets["camvid copy-paste"].train
    assert len(pasted) == 2
    added = [s for s in pasted if ((s.visible_ground == NO) & (s.ground == YES)).any()]
    assert added, "nothing hides known ground"


def test_camvid_s_classes(write_photo, tmp_path):
    ids = np.full((40, 40), 8)
    ids[:10], ids[20:30], ids[30:35], ids[35:] = 0, 3, 4, 11  # sky, road, pavement, void
    write_photo(tmp_path / "camvid" / "train", "a", ids)
    dataset = load_datasets(tmp_path)["camvid"]
    assert dataset.held_out == []
    (sample,) = dataset.train
    assert (sample.visible_ground[20:35] == YES).all()
    assert (sample.visible_ground[35:] == UNKNOWN).all()
    assert (sample.ground[:10] == NO).all()
    assert set(CAMVID.walkable) == {3, 4}


@pytest.mark.parametrize("exists", [True, False])
def test_no_dataset_at_all(tmp_path, exists):
    root = tmp_path / "data"
    if exists:
        root.mkdir()
    with pytest.raises(DatasetError, match=r"data: nothing to train on.* idd_lite, camvid"):
        load_datasets(root)
