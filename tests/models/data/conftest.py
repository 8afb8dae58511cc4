"""Folders of labelled photos."""

import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def write_photo():
    """The function that writes a photo and its label picture into a folder."""

    def write(folder, name, ids, image=None):
        (folder / "images").mkdir(parents=True, exist_ok=True)
        (folder / "labels").mkdir(parents=True, exist_ok=True)
        ids = np.asarray(ids, np.uint8)
        image = np.full((*ids.shape, 3), 90, np.uint8) if image is None else image
        Image.fromarray(image).save(folder / "images" / f"{name}.jpg")
        Image.fromarray(ids).save(folder / "labels" / f"{name}.png")

    return write
