"""Tiny models and made-up views that the benchmark's tests share."""

import json

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from PIL import Image
from predictions import make_prediction
from typer.testing import CliRunner

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge_bench.cli import app

SIZE = (32, 64)


@pytest.fixture(scope="session")
def green_is_ground(tmp_path_factory):
    """A model fixed to (32, 64): how green a pixel is, is the probability of visible ground; how
    red, of ground."""
    weights = np.zeros((4, 3, 1, 1), np.float32)
    weights[0, 1] = weights[1, 0] = 1 / 255
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["image"], ["float"], to=TensorProto.FLOAT),
            helper.make_node("Transpose", ["float"], ["planes"], perm=[0, 3, 1, 2]),
            helper.make_node("Conv", ["planes", "weights"], ["maps"]),
        ],
        "green",
        [helper.make_tensor_value_info("image", TensorProto.UINT8, [1, *SIZE, 3])],
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, [1, 4, *SIZE])],
        [numpy_helper.from_array(weights, "weights")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    metadata = ModelMetadata(
        "green", "edge", "fp32", (0.1, 100.0), None, "lanczos", "none", "0" * 64, "tests", "none"
    )
    helper.set_model_props(model, metadata.to_props())
    path = tmp_path_factory.mktemp("models") / "green.onnx"
    onnx.save(model, path)
    return path


@pytest.fixture(scope="session")
def fp_bench():
    """The function that runs `fp-bench` in this process. What would be a traceback is raised."""

    def run(*arguments):
        return CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)

    return run


@pytest.fixture(scope="session")
def camera():
    """Of pictures of (120, 160)."""
    return Intrinsics(140.0, 150.0, 80.0, 57.0)


@pytest.fixture(scope="session")
def pose():
    """Function: camera-to-world of a camera 1.5 m above the floor z = 0 that looks along y and
    down by so many degrees."""

    def make(down_deg=25.0, roll_deg=0.0, x=0.0, y=0.0):
        down, roll = np.radians([down_deg, roll_deg])
        forward = np.array([0, np.cos(down), -np.sin(down)])
        right = np.array([1.0, 0, 0])
        below = np.cross(forward, right)
        rolled = np.cos(roll) * right + np.sin(roll) * below
        made = np.eye(4)
        made[:3, :3] = np.stack([rolled, np.cross(forward, rolled), forward], axis=1)
        made[:3, 3] = x, y, 1.5
        return made

    return make


@pytest.fixture(scope="session")
def floor_of(camera):
    """Function: where each ray of a pose meets the floor z = 0: points (H, W, 3), and the depth
    there, 0 above the horizon. Closed form."""

    def find(camera_to_world, size=(120, 160)):
        rows, columns = np.mgrid[: size[0], : size[1]].astype(float)
        x, y = (columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy
        directions = np.stack([x, y, np.ones_like(x)], -1) @ camera_to_world[:3, :3].T
        with np.errstate(divide="ignore"):
            depth_m = np.where(
                directions[..., 2] < 0, -camera_to_world[2, 3] / directions[..., 2], 0
            )
        return camera_to_world[:3, 3] + depth_m[..., None] * directions, depth_m

    return find


@pytest.fixture(scope="session")
def predicted(camera):
    """Function: a prediction that says what it is told, at the size of its maps."""

    def make(visible, ground=None, visible_depth_m=None, ground_depth_m=None):
        ground = visible if ground is None else ground
        ones = np.ones(visible.shape, np.float32)
        return make_prediction(
            ones if ground_depth_m is None else ground_depth_m,
            ground=ground,
            visible_ground=visible,
            visible_depth_m=ones if visible_depth_m is None else visible_depth_m,
            intrinsics=camera,
        )

    return make


@pytest.fixture
def clip(tmp_path, camera, pose, floor_of):
    """Ten frames of a floor with a crate, from left and right; the world's z points up."""
    folder = tmp_path / "walk"
    (folder / "images").mkdir(parents=True)
    (folder / "depth").mkdir()
    low, high = np.array([-0.3, 1.7, 0]), np.array([0.3, 2.1, 0.4])
    frames = []
    for i, x in enumerate(np.linspace(-1.0, 1.0, 10)):
        view = pose(down_deg=35, x=x)
        points, floor_m = floor_of(view)
        directions = (points - view[:3, 3]) / np.where(floor_m > 0, floor_m, 1)[..., None]
        with np.errstate(divide="ignore"):
            first, second = (low - view[:3, 3]) / directions, (high - view[:3, 3]) / directions
        enter = np.minimum(first, second).max(-1)
        hit = (enter < np.maximum(first, second).min(-1)) & (floor_m > 0)
        depth_m = np.where(hit, enter, np.where(floor_m < 6, floor_m, 0))
        depth_mm = Image.fromarray(np.rint(1000 * depth_m).astype(np.uint16))
        depth_mm.save(folder / "depth" / f"f{i}.png")
        Image.new("RGB", (160, 120), (90, 90, 90)).save(folder / "images" / f"f{i}.jpg")
        frames.append({"name": f"f{i}", "camera_to_world": view.tolist()})
    K = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (folder / "sequence.json").write_text(
        json.dumps({"intrinsics": K, "gravity_direction": [0, 0, -1], "frames": frames})
    )
    return folder


@pytest.fixture(scope="session")
def scenes(tmp_path_factory):
    """A folder of three small synthetic scenes of the test split."""
    pytest.importorskip("embreex", reason="synthetic scenes are rendered by ray casting")
    from footprints_edge_models.scenes.make import make_scenes
    from footprints_edge_models.scenes.storage.files import SceneSettings

    folder = tmp_path_factory.mktemp("scenes") / "synthetic"
    make_scenes(folder, SceneSettings("test", 5, (96, 160)), [], 3, 1, lambda _: None)
    return folder
