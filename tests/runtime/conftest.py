"""Tiny models that honour the file contract, built on the fly; no trained weights needed."""

from pathlib import Path

import numpy as np
import pytest
from tiny_model import tiny_model_bytes
from videos import write_video

from footprints_edge.model import Model, load


@pytest.fixture(scope="session")
def tiny_path(tmp_path_factory) -> Path:
    """A model file of free input size."""
    path = tmp_path_factory.mktemp("models") / "tiny.onnx"
    path.write_bytes(tiny_model_bytes())
    return path


@pytest.fixture(scope="session")
def tiny(tiny_path) -> Model:
    """The model of `tiny_path`, loaded."""
    return load(tiny_path, threads=1)


@pytest.fixture
def picture() -> np.ndarray:
    """uint8 (60, 100, 3): no symmetry; left green, middle red, right blue, over a ramp."""
    rgb = np.zeros((60, 100, 3), np.uint8)
    rgb[:, :40, 1] = 220
    rgb[30:, 40:70, 0] = 200
    rgb[..., 2] = np.linspace(20, 250, 100, dtype=np.uint8)
    rgb[:10, :15] = 250
    return rgb


@pytest.fixture
def model_bytes():
    """The function that makes tiny models."""
    return tiny_model_bytes


@pytest.fixture
def clip(tmp_path) -> Path:
    """A video of 20 shades at 10 frames per second."""
    pytest.importorskip("cv2")
    return write_video(tmp_path / "clip.avi")
