"""Samples to store."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.gpu_kit.stored_view import GROUND_CODES, VISIBLE_CODES

SIZE = (60, 96)


def made_sample(seed, size=SIZE):
    """Smooth colours, labels of every kind in blocks, depths of two planes."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[: size[0], : size[1]]
    image = np.stack([rows * 4, columns * 2, rows + columns], -1).clip(0, 255).astype(np.uint8)

    def blocks(values):
        small = rng.choice(np.array(values, np.uint8), (-(-size[0] // 8), -(-size[1] // 8)))
        return small.repeat(8, 0).repeat(8, 1)[: size[0], : size[1]]

    return Sample(
        f"made/{seed}",
        image,
        Intrinsics(90.0, 100.0, size[1] / 2 - 3, size[0] / 2 + 2),
        blocks(VISIBLE_CODES),
        blocks(GROUND_CODES),
        (2 + rows / 10).astype(np.float16),
        np.where(rows % 16 > 3, 3 + columns / 20, 0).astype(np.float16),
        blocks([0, 1]),
    )


@pytest.fixture
def sample():
    """The function that makes a sample from a seed."""
    return made_sample
