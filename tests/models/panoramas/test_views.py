"""Views of panoramas: every pixel has the label and the colour of the direction it looks along."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.panoramas.labels import (
    FOOTPRINT,
    GROUND,
    IGNORED,
    VISIBLE_GROUND,
    read_panoramas,
)
from footprints_edge_models.panoramas.views import (
    PanoramaCamera,
    cut_labels,
    cut_picture,
    draw_view,
)

SIZE = (60, 80)


def directions(camera):
    """Azimuth and elevation of every pixel in degrees, by the camera's own axes."""
    heading, pitch, roll = np.radians([camera.heading_deg, camera.pitch_deg, camera.roll_deg])
    forward = np.array(
        [np.sin(heading) * np.cos(pitch), np.sin(pitch), np.cos(heading) * np.cos(pitch)]
    )  # x is azimuth 90, y is up, z is azimuth 0
    level_right = np.array([np.cos(heading), 0, -np.sin(heading)])
    level_down = np.cross(level_right, forward)
    level_down *= -np.sign(level_down[1])
    right = np.cos(roll) * level_right + np.sin(roll) * level_down
    down = np.cos(roll) * level_down - np.sin(roll) * level_right
    rows, columns = np.mgrid[: camera.size[0], : camera.size[1]].astype(float)
    x = (columns - camera.intrinsics.cx) / camera.intrinsics.fx
    y = (rows - camera.intrinsics.cy) / camera.intrinsics.fy
    rays = x[..., None] * right + y[..., None] * down + forward
    azimuth = np.degrees(np.arctan2(rays[..., 0], rays[..., 2])) % 360
    return azimuth, np.degrees(np.arcsin(rays[..., 1] / np.linalg.norm(rays, axis=-1)))


CAMERAS = [
    PanoramaCamera(SIZE, Intrinsics.from_hfov(fov, SIZE), *angles)
    for fov, angles in (
        (60, (90.0, 0.0, 0.0)),
        (80, (50.0, -25.0, 0.0)),
        (95, (300.0, -30.0, 8.0)),
        (70, (3.0, 10.0, -12.0)),
        (100, (200.0, -60.0, 30.0)),
    )
]


@pytest.mark.parametrize("camera", CAMERAS)
def test_labels_are_those_of_the_directions(write_panoramas, camera):
    (panorama,) = read_panoramas(write_panoramas("plain"))
    azimuth, elevation = directions(camera)
    ignored = elevation < -54
    taken = (azimuth > 36) & (azimuth < 72) & (elevation < -18) & (elevation > -36)
    ground = (elevation < -18) & ~taken & ~ignored
    expected = (
        VISIBLE_GROUND * (ground & (azimuth < 180))
        + GROUND * ground
        + FOOTPRINT * taken
        + IGNORED * ignored
    )
    # OpenCV fills a polygon's border, too: a quarter of a panorama's pixel is its to decide
    near = 0.5
    sure = np.ones(SIZE, bool)
    for value in (-18, -36, -54):
        sure &= np.abs(elevation - value) > near
    for value in (0, 36, 72, 180, 360):
        sure &= np.abs(azimuth - value) * np.cos(np.radians(elevation)) > near
    assert sure.mean() > 0.8
    np.testing.assert_array_equal(cut_labels(panorama, camera)[sure], expected[sure])


@pytest.mark.parametrize("camera", CAMERAS)
def test_colours_are_those_of_the_directions(write_panoramas, camera):
    (panorama,) = read_panoramas(write_panoramas("plain"))
    azimuth, elevation = directions(camera)
    picture = cut_picture(panorama, camera).astype(float)
    away = np.abs((azimuth + 180) % 360 - 180) * np.cos(np.radians(elevation)) > 6  # of the seam
    away &= np.abs(elevation) < 80
    assert np.abs(picture[..., 0] - azimuth * 250 / 360)[away].max() < 5
    assert np.abs(picture[..., 1] - (elevation + 90) * 250 / 180)[away].max() < 4


def test_a_view_depends_on_its_panorama_number_and_seed_alone(write_panoramas):
    first, second = read_panoramas(write_panoramas("plain", "other"))
    same = [draw_view(first, 3, 0) for _ in range(2)]
    assert same[0].camera == same[1].camera
    np.testing.assert_array_equal(same[0].image, same[1].image)
    others = [draw_view(first, 4, 0), draw_view(first, 3, 1), draw_view(second, 3, 0)]
    assert len({view.camera for view in (same[0], *others)}) == 4


def test_views_look_around_and_are_of_several_shapes(write_panoramas):
    (panorama,) = read_panoramas(write_panoramas("plain"))
    cameras = [draw_view(panorama, number, 0).camera for number in range(16)]
    headings = np.sort([camera.heading_deg for camera in cameras])
    assert np.diff(headings, append=headings[0] + 360).max() < 60
    assert {max(camera.size) for camera in cameras} == {512}
    assert len({camera.size for camera in cameras}) > 2
    for camera in cameras:
        fov = np.degrees(2 * np.arctan(max(camera.size) / 2 / camera.intrinsics.focal_px))
        assert 60 <= fov <= 105
