"""The checks that all engines share: input sizes, and what a network gives."""

from pathlib import Path

import numpy as np
import pytest

from footprints_edge.engines.engine import checked_input_size, checked_maps
from footprints_edge.errors import ModelError

FILE = Path("made.onnx")


def graph(height, width):
    output = ("maps", "tensor(float)", [1, 4, "H", "W"])
    return [("image", "tensor(uint8)", [1, height, width, 3]), output]


@pytest.mark.parametrize("size", [(0, 0), (-32, -32), (64000, 64000), (2**36, 32), (32, 8192)])
def test_sizes_that_cannot_be_are_refused(size):
    with pytest.raises(ModelError, match="fixed input size"):
        checked_input_size(FILE, graph(*size))


def test_usual_sizes_pass():
    assert checked_input_size(FILE, graph(256, 448)) == (256, 448)
    assert checked_input_size(FILE, graph("H", "W")) is None


@pytest.mark.parametrize(
    "maps",
    [
        np.zeros(()),
        np.zeros(7),
        np.zeros((1, 4, 30, 64)),
        np.zeros((0, 4, 32, 64)),
        np.zeros((5, 4, 32, 64)),
        np.full((1, 4, 32, 64), np.nan),
        np.full((1, 4, 32, 64), np.inf),
        np.full((1, 4, 32, 64), 1.5),
        np.full((1, 4, 32, 64), -0.001001),
    ],
)
def test_what_is_no_map_is_refused(maps):
    with pytest.raises(ModelError, match=r"made\.onnx gives"):
        checked_maps(FILE, maps.astype(np.float32), (32, 64))


def test_one_nan_is_seen():
    maps = np.full((1, 4, 32, 64), 0.5, np.float32)
    assert checked_maps(FILE, maps, (32, 64)) is maps
    maps[0, 2, 31, 63] = np.nan
    with pytest.raises(ModelError):
        checked_maps(FILE, maps, (32, 64))
