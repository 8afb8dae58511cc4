"""Vectors of a room whose maps are known, whatever the weights of the bundled model."""

import json
import shutil

import numpy as np
import pytest
from painted_room import HEIGHT_M, PITCH_DEG, painted

from footprints_edge_export.verification.check_vectors import check_vectors
from footprints_edge_export.verification.test_vectors import write_vectors
from footprints_edge_export.verification.vector_metres import NAMES


@pytest.fixture(scope="module")
def vectors(tmp_path_factory):
    folder = tmp_path_factory.mktemp("painted")
    model, photo = painted(folder)
    write_vectors(model, folder / "vectors", photo)
    return folder / "vectors"


@pytest.fixture(scope="module")
def entries(vectors):
    """By name."""
    written = json.loads((vectors / "vectors.json").read_text())["vectors"]
    return {entry["name"]: entry for entry in written}


def plane_of(vectors, entry):
    return json.loads((vectors / entry["files"]["ground_plane"]).read_text())


def test_the_planes_are_those_of_the_room(vectors, entries):
    refused = {"refused": "impossible_pose", "wall": "no_ground"}
    for name, entry in entries.items():
        plane = plane_of(vectors, entry)
        assert plane["refused"] == refused.get(name)
        if name not in refused:
            assert plane["camera_height_m"] == pytest.approx(HEIGHT_M, rel=0.02)
            assert plane["pitch_deg"] == pytest.approx(PITCH_DEG, abs=0.2)


def test_all_with_a_plane_have_a_path_and_ground_of_either_kind(vectors, entries):
    for name in entries.keys() - {"refused", "wall"}:
        assert set(NAMES) <= set(entries[name]["files"]), name
        assert entries[name]["path"]["length_m"] > 1
        cells = np.load(vectors / entries[name]["files"]["occupancy"])
        assert set(np.unique(cells)) == {0, 1, 2, 3}, name


def test_a_path_that_slips_between_two_closed_cells_fails(vectors, entries, tmp_path):
    """Over the kerb, whose cells meet in their corners: the way round leads past its end."""
    outputs = tmp_path / "port"
    shutil.copytree(vectors, outputs)
    entry = entries["known_pose"]
    path_m = np.load(vectors / entry["files"]["path_m"])
    assert np.linalg.norm(path_m[-1] - path_m[0]) < 0.1
    assert entry["path"]["length_m"] > 1
    np.save(outputs / entry["files"]["path_m"], path_m[[0, -1]])
    failing = {finding.quantity for finding in check_vectors(vectors, outputs) if not finding.holds}
    assert failing == {"path_m of the port's maps"}
