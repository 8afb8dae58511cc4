"""The camera of a `CameraInfo`."""

import numpy as np
import pytest

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.calibration import Calibration
from footprints_edge.ros.camera_info import camera_of

pytest.importorskip("rosbags")

from bags import Messages

K = (600.0, 0, 319.5, 0, 610.0, 239.5, 0, 0, 1)
SIZE = (480, 640)


def info(ros=2, **changed):
    return Messages(ros).camera_info(0, **{"k": K, "size": SIZE, **changed})


def region(ros=2, **changed):
    fields = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
    return Messages(ros).make("sensor_msgs/msg/RegionOfInterest", **{**fields, **changed})


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize("d", [(), (0,) * 5])
def test_without_distortion_k_is_the_camera(ros, d):
    assert camera_of(info(ros, d=d))(SIZE) == Intrinsics(600, 610, 319.5, 239.5)


def test_a_picture_at_another_size_has_the_scaled_camera():
    camera = camera_of(info())
    assert camera((240, 320)) == Intrinsics(600, 610, 319.5, 239.5).scaled(SIZE, (240, 320))
    with pytest.raises(IntrinsicsError, match="is 640 x 640 pixels, its CameraInfo is for 640"):
        camera((640, 640))


def test_an_uncalibrated_camera_is_none():
    assert camera_of(info(k=(0,) * 9)) is None


def test_a_region_of_interest_moves_the_centre_and_binning_halves_the_focal_length():
    cropped = info(
        roi=region(x_offset=100, y_offset=40, width=400, height=300), binning_x=2, binning_y=2
    )
    camera = camera_of(cropped)((150, 200))
    # the edges of the region, as rays
    assert (-0.5 - camera.cx) / camera.fx == pytest.approx((99.5 - 319.5) / 600)
    assert (199.5 - camera.cx) / camera.fx == pytest.approx((499.5 - 319.5) / 600)
    assert (-0.5 - camera.cy) / camera.fy == pytest.approx((39.5 - 239.5) / 610)
    assert (149.5 - camera.cy) / camera.fy == pytest.approx((339.5 - 239.5) / 610)


def test_rectified_pictures_have_the_camera_p_and_no_distortion():
    p = (500.0, 0, 300, -40, 0, 505, 200, 0, 0, 0, 1, 0)
    camera = camera_of(info(d=(0.1, -0.2, 0, 0, 0), p=p), rectified=True)
    assert camera(SIZE) == Intrinsics(500, 505, 300, 200)


@pytest.mark.parametrize(
    ("model", "d"),
    [
        ("plumb_bob", (-0.3, 0.1, 0.001, -0.002, 0)),
        ("rational_polynomial", (0.4, 0.1, 0, 0, 0.01, 0.7, 0.2, 0.03)),
        ("equidistant", (0.05, 0.01, -0.002, 0.0003)),
    ],
)
def test_distortion_is_rectified_as_by_a_calibration_file(tmp_path, model, d):
    pytest.importorskip("cv2")
    file = tmp_path / "camera.yaml"
    file.write_text(
        f"image_width: 640\nimage_height: 480\ndistortion_model: {model}\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {list(map(float, K))}\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: {len(d)}\n  data: {list(map(float, d))}\n"
    )
    stated, read = camera_of(info(d=d, model=model)), Calibration.read(file)
    assert (stated.size, stated.model) == (read.size, read.model)
    np.testing.assert_array_equal(stated.matrix, read.matrix)
    np.testing.assert_array_equal(stated.distortion, read.distortion)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"model": "ftheta", "d": (0.1,) * 4}, "'ftheta'; plumb_bob"),
        ({"d": (0.1,) * 3}, "plumb_bob has 3 coefficients"),
        ({"d": (np.nan,) * 5}, "finite"),
        ({"k": (-1.0, 0, 1, 0, 1, 1, 0, 0, 1)}, "fx is -1"),
        ({"k": (np.nan, 0, 1, 0, 1, 1, 0, 0, 1)}, "fx is nan"),
    ],
)
def test_numbers_that_cannot_be_a_camera_are_refused(changed, reason):
    with pytest.raises(IntrinsicsError, match=reason):
        camera_of(info(**changed))
