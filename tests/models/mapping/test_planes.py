import numpy as np
import pytest

from footprints_edge_models.mapping.planes import Plane, fit_plane

NORMAL = np.array([0.2, -0.9, 0.3]) / np.linalg.norm([0.2, -0.9, 0.3])


@pytest.fixture
def on_plane():
    rng = np.random.default_rng(1)
    plane = Plane(NORMAL, -1.4)
    return rng.uniform(-5, 5, (3000, 2)) @ np.stack(plane.axes()) - 1.4 * NORMAL


def test_a_third_of_outliers_changes_nothing(on_plane):
    rng = np.random.default_rng(2)
    noisy = on_plane + rng.normal(0, 0.01, on_plane.shape)
    noisy[:1000] = rng.uniform(-5, 5, (1000, 3))
    found = fit_plane(noisy, np.random.default_rng(0)).facing(NORMAL)
    np.testing.assert_allclose(found.normal, NORMAL, atol=1e-3)
    assert found.offset_m == pytest.approx(-1.4, abs=2e-3)


def test_axes_span_the_plane_at_right_angles():
    first, second = Plane(NORMAL, 3.0).axes()
    frame = np.stack([first, second, NORMAL])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)


def test_height_is_signed_distance(on_plane):
    plane = Plane.through(on_plane).facing(NORMAL)
    np.testing.assert_allclose(plane.height_m(on_plane + 0.7 * NORMAL), 0.7, atol=1e-9)
    flipped = plane.facing(-NORMAL)
    np.testing.assert_allclose(flipped.height_m(on_plane + 0.7 * NORMAL), -0.7, atol=1e-9)


@pytest.mark.parametrize("count", [0, 2])
def test_too_few_points_carry_no_plane(count):
    assert fit_plane(np.zeros((count, 3)), np.random.default_rng(0)) is None


def test_points_in_a_row_carry_no_plane():
    row = np.linspace(0, 1, 50)[:, None] * np.array([1.0, 2.0, 3.0])
    assert fit_plane(row, np.random.default_rng(0)) is None


def test_only_accepted_hypotheses_may_win(on_plane):
    def level(normals, _offsets):
        return np.abs(normals[:, 1]) > 0.999

    assert fit_plane(on_plane, np.random.default_rng(0), accept=level) is None
    floor = np.random.default_rng(3).uniform(-5, 5, (1500, 3)) * [1, 0, 1]
    both = np.concatenate([on_plane, floor])  # twice as many points on the tilted plane
    found = fit_plane(both, np.random.default_rng(0), trials=500, accept=level)
    np.testing.assert_allclose(np.abs(found.normal), [0, 1, 0], atol=1e-2)
