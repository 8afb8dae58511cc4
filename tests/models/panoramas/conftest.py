"""A folder of panoramas whose ground has a closed form."""

import json

import numpy as np
import pytest
from PIL import Image

HEIGHT, WIDTH = 128, 256


def band(left, top, right, bottom):
    """A rectangle of a panorama from shares of its width and height, as a polygon."""
    x0, x1, y0, y1 = left * WIDTH, right * WIDTH, top * HEIGHT, bottom * HEIGHT
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]


@pytest.fixture
def write_panoramas(tmp_path):
    """The function that writes panoramas by these names.

    Ground lies more than 18 degrees below the horizon, seen in azimuths from 0 to 180 degrees; a
    thing takes azimuths 36 to 72 between 18 and 36 degrees below it. Nobody knows what is more than
    54 degrees down. Red and green rise with azimuth and elevation.
    """

    def write(*names):
        folder = tmp_path / "assets" / "panoramas"
        (folder / "labels").mkdir(parents=True)
        rows, columns = np.mgrid[:HEIGHT, :WIDTH] + 0.5
        image = np.stack(
            [columns * 250 / WIDTH, 250 - rows * 250 / HEIGHT, np.full_like(rows, 90)], -1
        ).astype(np.uint8)
        index = []
        for name in names:
            Image.fromarray(image).save(folder / f"{name}.jpg", quality=98)
            labels = {
                "width": WIDTH,
                "height": HEIGHT,
                "ground": [band(0, 0.6, 1, 1)],
                "visible": [band(0, 0.6, 0.5, 1)],
                "footprints": [band(0.1, 0.6, 0.2, 0.7)],
                "ignore": [band(0, 0.8, 1, 1)],
            }
            (folder / "labels" / f"{name}.json").write_text(json.dumps(labels))
            facts = {"file": f"{name}.jpg", "shows": "a plain", "setting": "outdoor"}
            credit = {"licence": "CC0-1.0", "author": "Somebody", "source": f"of {name}"}
            index.append(facts | credit)
        (folder / "index.json").write_text(json.dumps(index))
        return folder

    return write
