"""The OpenVINO engine: the same contract as onnxruntime's."""

import ast
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import onnxruntime as ort
import pytest

import footprints_edge as fp
from footprints_edge.outputs.json_summary import summarise

RUNTIME = Path(fp.__file__).parent


@pytest.fixture
def openvino():
    return pytest.importorskip("openvino", reason="the extra openvino is not installed")


@pytest.mark.usefixtures("openvino")
class TestOpenVino:
    def test_predictions_are_those_of_onnxruntime(self, tiny_path, tiny, picture):
        found = fp.load(tiny_path, engine="openvino", threads=1).predict(picture)
        expected = tiny.predict(picture)
        np.testing.assert_array_equal(found.ground, expected.ground)
        np.testing.assert_allclose(found.visible_depth_m, expected.visible_depth_m, rtol=1e-4)

    def test_the_result_names_the_engine(self, tiny_path, tiny, picture, openvino):
        model = fp.load(tiny_path, engine="openvino", threads=1)
        prediction = model.predict(picture)
        version = openvino.__version__.partition("-")[0]
        assert prediction.model.runtime == f"openvino {version}"
        assert summarise(prediction)["versions"]["runtime"] == f"openvino {version}"
        assert tiny.predict(picture).model.runtime == f"onnxruntime {ort.__version__}"
        assert (model.engine.providers, model.engine.threads) == (("CPU",), 1)
        assert (model.sha256, model.metadata) == (tiny.sha256, tiny.metadata)

    def test_free_and_fixed_sizes(self, tiny_path, tmp_path, model_bytes):
        (tmp_path / "fixed.onnx").write_bytes(model_bytes((32, 64)))
        free = fp.load(tiny_path, engine="openvino", threads=1).engine
        fixed = fp.load(tmp_path / "fixed.onnx", engine="openvino", threads=1).engine
        assert (free.input_size, fixed.input_size) == (None, (32, 64))
        for height in range(32, 32 * 12, 32):  # more sizes than are kept
            image = np.full((1, height, 64, 3), height % 256, np.uint8)
            maps = free.run(image)
            assert (maps.shape, maps.dtype) == ((1, 4, height, 64), np.float32)
            np.testing.assert_allclose(maps[0, 0], height % 256 / 255, atol=1e-6)
        with pytest.raises(fp.ModelError, match=r"failed on an input of \(1, 64, 64, 3\)"):
            fixed.run(np.zeros((1, 64, 64, 3), np.uint8))

    def test_session_options_are_properties_of_its_plugin(self, tiny_path, picture):
        options = {"LP_TRANSFORMS_MODE": "NO"}
        assert fp.load(tiny_path, engine="openvino", session_options=options)(picture).map_size
        for wrong in ({"LP_TRANSFORMS_MODE": "MAYBE"}, {"NO_SUCH_PROPERTY": "1"}):
            with pytest.raises(
                fp.ModelError, match=f"refuses the session options.*{next(iter(wrong))}"
            ):
                fp.load(tiny_path, engine="openvino", session_options=wrong)
        with pytest.raises(fp.ModelError, match="NUM_STREAMS"):
            fp.load(tiny_path, engine="openvino", session_options={"NUM_STREAMS": "2"})

    def test_one_model_serves_many_threads(self, tiny_path):
        engine = fp.load(tiny_path, engine="openvino", threads=1).engine
        images = [np.full((1, 32, 64, 3), value, np.uint8) for value in range(0, 250, 10)]
        with ThreadPoolExecutor(4) as pool:
            found = list(pool.map(engine.run, images))
        for image, maps in zip(images, found, strict=True):
            np.testing.assert_allclose(maps[0, 0], image[0, ..., 1] / 255, atol=1e-6)

    @pytest.mark.parametrize(
        ("content", "reason"),
        [
            (b"", "0 bytes"),
            (b"PK\x03\x04 archive", "fp-export convert"),
            (b"\x08\x07garbage" * 9, "damaged"),
        ],
    )
    def test_other_files_are_refused(self, content, reason, tmp_path):
        (tmp_path / "broken.onnx").write_bytes(content)
        with pytest.raises(fp.ModelError, match=rf"broken\.onnx.*{reason}"):
            fp.load(tmp_path / "broken.onnx", engine="openvino")

    def test_other_graphs_and_models_are_refused(self, tmp_path, model_bytes):
        (tmp_path / "other.onnx").write_bytes(model_bytes(output="logits"))
        with pytest.raises(fp.ModelError, match=r"logits.*expected image uint8 \[1, H, W, 3\]"):
            fp.load(tmp_path / "other.onnx", engine="openvino")
        (tmp_path / "bare.onnx").write_bytes(model_bytes(props={}))
        with pytest.raises(fp.ModelError, match="not one of footprints-edge"):
            fp.load(tmp_path / "bare.onnx", engine="openvino")

    def test_threads_must_be_positive(self, tiny_path):
        with pytest.raises(fp.ModelError, match="threads is 0"):
            fp.load(tiny_path, engine="openvino", threads=0)


def test_a_missing_openvino_names_the_extra(tiny_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "openvino", None)
    with pytest.raises(fp.ModelError, match=r"pip install 'footprints-edge\[openvino\]'"):
        fp.load(tiny_path, engine="openvino")


def test_only_one_file_imports_openvino_and_only_on_demand():
    users = {
        path.name: node.col_offset
        for path in RUNTIME.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import) and any(a.name == "openvino" for a in node.names)
    }
    assert list(users) == ["openvino.py"]
    assert users["openvino.py"] > 0  # inside a function
