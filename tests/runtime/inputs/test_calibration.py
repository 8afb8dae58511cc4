"""Calibration files, and rectification against OpenCV's own projection of points."""

import numpy as np
import pytest

from footprints_edge.errors import IntrinsicsError
from footprints_edge.inputs import calibration as calibration_module
from footprints_edge.inputs.calibration import Calibration
from footprints_edge.inputs.images import DecodedImage, ReducibleFile

cv2 = pytest.importorskip("cv2")

K = [[300.0, 0, 322.0], [0, 302.0, 241.0], [0, 0, 1]]
LENSES = {
    "plumb_bob": [-0.28, 0.07, 0.001, -0.0005, 0.0],
    "rational_polynomial": [0.4, -0.2, 0.0004, -0.0003, 0.01, 0.75, -0.2, 0.02],
    "equidistant": [-0.01, 0.004, -0.002, 0.0003],
}


def ros(model):
    numbers = ", ".join(map(str, np.ravel(K)))
    return (
        "image_width: 640\nimage_height: 480\ncamera_name: head\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{numbers}]\n"
        f"distortion_model: {model}\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: {len(LENSES[model])}\n"
        f"  data: [{', '.join(map(str, LENSES[model]))}]\n"
    )


def write_opencv(path, model):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array(K))
    storage.write("distortion_coefficients", np.array([LENSES[model]]))
    if model == "equidistant":
        storage.write("fisheye_model", 1)
    storage.release()


def read(tmp_path, model, kind):
    path = tmp_path / "camera.yaml"
    path.write_text(ros(model)) if kind == "ros" else write_opencv(path, model)
    return Calibration.read(path)


@pytest.mark.parametrize("kind", ["ros", "opencv"])
@pytest.mark.parametrize("model", LENSES)
def test_files_of_both_kinds_are_read(tmp_path, model, kind):
    found = read(tmp_path, model, kind)
    assert (found.size, found.model) == ((480, 640), model)
    np.testing.assert_allclose(found.matrix, K)
    np.testing.assert_allclose(found.distortion, LENSES[model])


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("model", LENSES)
def test_a_point_lies_where_the_rectified_camera_sees_it(tmp_path, model, times):
    """A bright spot, drawn where OpenCV projects a point through the lens."""
    calibration = read(tmp_path, model, "ros")
    point = np.array([[[0.2, -0.15, 1.0]]])
    matrix, lens = np.array(K), np.array(LENSES[model])
    none = np.zeros(3)
    project = cv2.fisheye.projectPoints if model == "equidistant" else cv2.projectPoints
    (x, y) = (np.ravel(project(point, none, none, matrix, lens)[0]) + 0.5) * times - 0.5
    columns, rows = np.meshgrid(np.arange(640 * times), np.arange(480 * times))
    spot = 255 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * (3 * times) ** 2))
    picture = np.repeat(spot.astype(np.uint8)[..., None], 3, axis=2)
    image, camera = calibration.rectified(DecodedImage(picture, name="a.jpg"))
    assert (image.name, image.size, camera.source) == (
        "a.jpg",
        (480 * times, 640 * times),
        "rectified",
    )
    bright = image.rgb[..., 0].astype(float) ** 2
    found = [(bright * axis).sum() / bright.sum() for axis in (columns, rows)]
    expected = [camera.cx + camera.fx * 0.2, camera.cy - camera.fy * 0.15]
    np.testing.assert_allclose(found, expected, atol=0.3 * times)


def test_no_black_border_is_left(tmp_path):
    white = np.full((480, 640, 3), 255, np.uint8)
    image, _ = read(tmp_path, "plumb_bob", "ros").rectified(DecodedImage(white))
    assert image.rgb.min() > 250


def test_the_remap_is_computed_once(tmp_path, monkeypatch):
    calibration = read(tmp_path, "plumb_bob", "ros")
    white = DecodedImage(np.full((480, 640, 3), 255, np.uint8))
    calibration.rectified(white)
    monkeypatch.setattr(Calibration, "_make_remap", None)
    calibration.rectified(white)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "needs image_width"),
        ("image_width: 640\n", "needs image_width"),
        ("{[}", "calibration"),
        (ros("plumb_bob").replace("plumb_bob", "thin_prism"), "'thin_prism'"),
        (ros("plumb_bob").replace("-0.28, 0.07, 0.001,", ""), "coefficients"),
        (ros("plumb_bob").replace("300.0", "-300.0"), "focal length"),
    ],
)
def test_a_bad_file_is_named(tmp_path, text, says):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(IntrinsicsError, match=says) as error:
        Calibration.read(path)
    assert "camera.yaml" in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "%YAML:1.0\n---\ncamera_matrix:\n   dt: d\ndistortion_coefficients: !!opencv-matrix\n"
        "   rows: 4\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0. ]\n",
        "a: &a [*a]\n",
        "[" * 10_000,
        "a: [" + "1, " * 400_000 + "]",
        "a: &a [1, 1]\nb: &b [*a, *a]\nK: {<<: [*b, *b]}\n",
        "image_width: .nan\nimage_height: 480\nK: [1, 0, 1, 0, 1, 1, 0, 0, 1]\nD: [0, 0, 0, 0]\n",
        "image_width: 9\nimage_height: 9\nK: [1, [2], {}, 0, 1, 1, 0, 0, 1]\nD: [0, 0, 0, 0]\n",
        "? [a]\n: b\n",
        "just a line",
        "a: \x00",
        'a: "\\UFFFFFFFF"\n',
        'a: "\\U7FFFFFFF"\n',
        "%YAML 1." + "1" * 5000 + "\n---\na: 1\n",
        "\n%YAML 1." + "1" * 5000 + "\n---\na: 1\n",
        "a: !" + "a" * 300_000 + "!x y\n",
    ],
)
def test_hostile_yaml_is_refused(tmp_path, text):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(IntrinsicsError, match="calibration") as error:
        Calibration.read(path)
    assert len(str(error.value)) < 1000


@pytest.mark.parametrize(
    ("word", "model"), [("false", "plumb_bob"), ("no", "plumb_bob"), ("0", "plumb_bob"),
                        ("true", "equidistant"), ("1", "equidistant")]
)  # fmt: skip
def test_a_file_says_in_its_way_whether_it_is_of_a_fisheye(tmp_path, word, model):
    path = tmp_path / "camera.yaml"
    numbers = ", ".join(map(str, np.ravel(K)))
    path.write_text(
        f"\ufeff\n%YAML:1.0\n---\nwidth: 640\nheight: 480\nK: [{numbers}]\nD: [0, 0, 0, 0]\n"
        f"fisheye: {word}\n"
    )
    assert Calibration.read(path).model == model


def test_numbers_are_read_however_they_are_written(tmp_path):
    path = tmp_path / "camera.yaml"
    path.write_text(
        "%YAML 1.1\n---\nwidth: 640\nheight: 4.8e2\nK: [[3e2, 0, 322.], [0, 302, 241], [0, 0, 1]]\n"
        "D: !<tag:yaml.org,2002:opencv-matrix>\n  rows: 1\n  cols: 4\n  dt: d\n"
        "  data: [-2.8e-01, .07, 1.0e-3,\n    -5.e-04]\n"
    )
    found = Calibration.read(path)
    assert found.size == (480, 640)
    np.testing.assert_allclose(found.matrix, K)
    np.testing.assert_allclose(found.distortion, [-0.28, 0.07, 0.001, -0.0005])


def test_a_picture_of_another_shape_is_refused(tmp_path):
    calibration = read(tmp_path, "plumb_bob", "ros")
    with pytest.raises(IntrinsicsError, match="480 x 640"):
        calibration.rectified(DecodedImage(np.zeros((640, 480, 3), np.uint8)))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(IntrinsicsError, match=r"none\.yaml"):
        Calibration.read(tmp_path / "none.yaml")


def test_a_very_large_picture_is_rectified_at_a_reduced_size(tmp_path, monkeypatch):
    calibration = read(tmp_path, "plumb_bob", "ros")
    whole, of_whole = calibration.rectified(DecodedImage(np.zeros((960, 1280, 3), np.uint8)))
    monkeypatch.setattr(calibration_module, "_MOST_PX", 960 * 1280 - 1)
    file = ReducibleFile(b"", "a.jpg", (960, 1280))
    image = DecodedImage(np.zeros((480, 640, 3), np.uint8), "a.jpg", file=file)
    reduced, camera = calibration.rectified(image)
    assert (whole.size, whole.notes, reduced.size) == ((960, 1280), (), (480, 640))
    assert "640 x 480" in reduced.notes[0]
    assert camera.fx == pytest.approx(of_whole.fx / 2, rel=0.01)


@pytest.mark.parametrize("side", [".nan", ".inf", "-5", "1e300"])
def test_a_side_that_no_picture_has_is_refused(tmp_path, side):
    calibration = read(tmp_path, "plumb_bob", "ros")
    assert calibration.size == (480, 640)
    (path,) = tmp_path.iterdir()
    path.write_text(path.read_text().replace("image_width: 640", f"image_width: {side}"))
    with pytest.raises(IntrinsicsError, match=r"cannot be|not a number"):
        Calibration.read(path)
