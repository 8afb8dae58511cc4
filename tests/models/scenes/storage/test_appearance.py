"""Numbers of a picture against closed forms."""

import json

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge_models.cli import app
from footprints_edge_models.scenes.assets.textures.noise import noise
from footprints_edge_models.scenes.storage.appearance import LONGER_SIDE_PX, appearance, compare

SIDE = LONGER_SIDE_PX


def test_half_black_half_red():
    picture = np.zeros((SIDE, SIDE, 3), np.uint8)
    picture[:, SIDE // 2 :, 0] = 255
    seen = appearance(picture)
    assert seen.brightness == pytest.approx(0.299 / 2, abs=1e-3)
    assert seen.contrast == pytest.approx(0.299 / 2, abs=1e-3)
    assert (seen.dark, seen.bright) == (0.5, 0.0)
    assert seen.saturation == pytest.approx(0.5, abs=1e-3)
    assert seen.colourful == 1.0
    assert seen.warmth == pytest.approx(0.5, abs=1e-3)
    assert seen.edges == pytest.approx(2 / SIDE, abs=1e-6)
    assert seen.flat > 0.95


@pytest.mark.parametrize("roughness", [0.5, 1.2])
def test_the_slope_is_that_of_the_noise(roughness):
    grey = noise(np.random.default_rng(0), roughness, side=SIDE)
    picture = np.repeat(np.clip(128 + 30 * grey, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
    assert appearance(picture).spectrum_slope == pytest.approx(-2 * roughness, abs=0.15)


def test_like_pictures_are_close_and_unlike_ones_far():
    rng = np.random.default_rng(0)
    dark = [appearance(rng.integers(0, 80, (64, 64, 3), np.uint8)) for _ in range(4)]
    bright = [appearance(rng.integers(120, 255, (64, 64, 3), np.uint8)) for _ in range(4)]
    assert all(distance == 0 for _, _, distance in compare(dark, dark).values())
    first, second, distance = compare(dark, bright)["brightness"]
    assert distance == 1 and first < 0.2 < second


def test_the_command_shows_photos_beside_the_pictures(tmp_path):
    photos = tmp_path / "photos"
    photos.mkdir()
    for number in range(3):
        picture = np.full((60, 90, 3), 250 - number, np.uint8)
        cv2.imwrite(str(photos / f"{number}.png"), picture)
    out, sheet = tmp_path / "out", tmp_path / "sheet.png"
    arguments = ["scenes", str(out), "--count", "1", "--size", "64x96", "-j", "1"]
    beside = ["--beside", str(photos)]
    assert CliRunner().invoke(app, [*arguments, *beside]).exit_code == 2
    done = CliRunner().invoke(app, [*arguments, *beside, "--preview", str(sheet)])
    assert done.exit_code == 0, done.output
    said = json.loads(done.stdout.splitlines()[-1])["made_photos_distance"]
    assert said["brightness"][1] == pytest.approx(249 / 255, abs=1e-3)
    assert said["bright"][1] == 1
    right = cv2.imread(str(sheet))[:, -6 * 224 :]
    assert right[50:100, 60:160].min() > 240  # a photo, unlabelled
