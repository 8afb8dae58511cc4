"""`fp-infer --path`, and the occupancy grid as a file."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("scipy")


@pytest.fixture
def green_photo(tmp_path):
    """A picture that the tiny model finds to be ground below a wall, on a plane."""
    rgb = np.zeros((96, 128, 3), np.uint8)
    rgb[24:, :, 1] = 250
    rgb[..., 2] = np.linspace(30, 250, 96, dtype=np.uint8)[:, None]
    Image.fromarray(rgb).save(tmp_path / "green.png")
    return tmp_path / "green.png"


def test_path_draws_both_paths_side_by_side(infer, green_photo):
    result = infer(green_photo, "--path", "20,90", "110,40", "--margin", "0.001")
    assert result.exit_code == 0, result.output
    drawn = Path(f"{green_photo}.path.png")
    assert str(drawn) in result.stdout.splitlines()
    with Image.open(drawn) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    yellow = np.abs(pixels - (255, 235, 59)).max(axis=-1) < 20
    middle = pixels.shape[1] // 2
    assert yellow[:, :middle].any() and yellow[:, middle:].any()


def test_errors_of_a_path_are_explained(infer, green_photo):
    outside = infer(green_photo, "--path", "20,90", "999,40")
    assert outside.exit_code == 1
    assert "the goal (999.0, 40.0) px is outside the picture" in outside.stderr
    nonsense = infer(green_photo, "--path", "20,90", "here")
    assert nonsense.exit_code == 2
    assert "X0,Y0 X1,Y1" in nonsense.stderr


def test_the_robots_height_reaches_the_results(infer, green_photo):
    result = infer(green_photo, "--format", "json", "--robot-height", "0.6")
    assert result.exit_code == 0, result.output
    facts = json.loads(Path(f"{green_photo}.json").read_text())
    assert (facts["robot_height_m"], facts["nearest_obstacle_m"]) == (0.6, None)
    wrong = infer(green_photo, "--robot-height", "0.1")
    assert wrong.exit_code == 2
    assert "more than the 0.15 m of a step" in wrong.stderr


def test_an_assumed_lens_is_said_below_paths_and_grids(infer, green_photo):
    """The line is there without --hfov, and only then."""
    sizes = []
    for options in ((), ("--hfov", "60")):
        formats = ("--format", "topdown_picture", "--overwrite")
        result = infer(green_photo, "--path", "20,90", "110,40", *formats, *options)
        assert result.exit_code == 0, result.output
        for ending in (".path.png", ".topdown_picture.png"):
            with Image.open(f"{green_photo}{ending}") as image:
                sizes.append(image.size)
    assert [size[1] for size in sizes[:2]] > [size[1] for size in sizes[2:]]
    assert [size[0] for size in sizes[:2]] == [size[0] for size in sizes[2:]]


def test_topdown_writes_the_map_of_a_picture(infer, green_photo):
    result = infer(green_photo, "--format", "topdown")
    assert result.exit_code == 0, result.output
    assert [Path(line).name for line in result.stdout.splitlines()] == [
        "green.png.topdown.png",
        "green.png.topdown.yaml",
    ]
