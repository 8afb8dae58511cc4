import numpy as np
import pytest

from footprints_edge.engines import onnxruntime_engine as session_module
from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine, available_providers
from footprints_edge.errors import ModelError


def test_maps_of_a_free_and_a_fixed_size(tiny_path, tmp_path, model_bytes):
    fixed_path = tmp_path / "fixed.onnx"
    fixed_path.write_bytes(model_bytes((32, 64)))
    free, fixed = OnnxRuntimeEngine(tiny_path, threads=1), OnnxRuntimeEngine(fixed_path, threads=1)
    assert (free.input_size, fixed.input_size) == (None, (32, 64))
    image = np.random.default_rng(0).integers(0, 256, (1, 32, 64, 3), np.uint8)
    maps = free.run(image)
    assert maps.shape == (1, 4, 32, 64)
    assert maps.dtype == np.float32
    np.testing.assert_allclose(maps[0, 0], image[0, ..., 1] / 255, atol=1e-6)
    np.testing.assert_array_equal(maps, fixed.run(image))


def test_it_says_what_it_runs(tiny_path):
    session = OnnxRuntimeEngine(tiny_path, threads=1)
    assert session.path == tiny_path
    assert session.providers == ("CPUExecutionProvider",)
    assert session.props["footprints.name"] == "tiny"
    assert (session.threads, OnnxRuntimeEngine(tiny_path).threads >= 1) == (1, True)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "0 bytes"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:1", "git lfs pull"),
        (b"<!DOCTYPE html><html>404</html>", "web page"),
        (b"PK\x03\x04 archive", "fp-export convert"),
        (b"\x08\x07garbage" * 9, "damaged"),
    ],
)
def test_what_is_no_model_is_refused_by_name_and_size(content, reason, tmp_path):
    path = tmp_path / "broken.onnx"
    path.write_bytes(content)
    with pytest.raises(ModelError, match=rf"broken\.onnx.*{reason}") as caught:
        OnnxRuntimeEngine(path)
    assert f"{len(content)} bytes" in str(caught.value)


def test_a_truncated_model_is_refused(tmp_path, model_bytes):
    path = tmp_path / "cut.onnx"
    path.write_bytes(model_bytes()[:200])
    with pytest.raises(ModelError, match="sha256"):
        OnnxRuntimeEngine(path)


def test_a_missing_model_is_refused(tmp_path):
    with pytest.raises(ModelError, match="cannot be read"):
        OnnxRuntimeEngine(tmp_path / "nothing.onnx")


def test_other_graphs_are_refused(tmp_path, model_bytes):
    path = tmp_path / "other.onnx"
    path.write_bytes(model_bytes(output="logits"))
    with pytest.raises(ModelError, match=r"logits.*expected image uint8 \[1, H, W, 3\]"):
        OnnxRuntimeEngine(path)


@pytest.mark.parametrize("providers", [["NoSuchProvider"], [], ["CPUExecutionProvider", "Other"]])
def test_unknown_providers_are_refused_never_replaced(providers, tiny_path):
    with pytest.raises(ModelError, match="CPUExecutionProvider"):
        OnnxRuntimeEngine(tiny_path, providers=providers)


@pytest.mark.filterwarnings("ignore:Specified provider")
def test_a_provider_that_does_not_start_is_not_replaced_silently(tiny_path, monkeypatch):
    assert "CPUExecutionProvider" in available_providers()
    monkeypatch.setattr(
        session_module,
        "available_providers",
        lambda: ["CUDAExecutionProvider", "CPUExecutionProvider"],
    )
    with pytest.raises(ModelError, match="does not start"):
        OnnxRuntimeEngine(tiny_path, providers=["CUDAExecutionProvider"])


def test_threads_must_be_positive(tiny_path):
    with pytest.raises(ModelError, match="threads is 0"):
        OnnxRuntimeEngine(tiny_path, threads=0)
