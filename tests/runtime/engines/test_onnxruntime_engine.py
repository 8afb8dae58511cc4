"""The onnxruntime engine: files, providers and plug-ins."""

import sys
from types import ModuleType

import numpy as np
import onnxruntime as ort
import pytest

import footprints_edge as fp
from footprints_edge.engines import onnxruntime_engine as engine_module
from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine, available_providers
from footprints_edge.errors import ModelError


def test_maps_of_a_dynamic_and_a_fixed_size(tiny_path, tmp_path, model_bytes):
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


def test_the_engine_describes_itself(tiny_path):
    engine = OnnxRuntimeEngine(tiny_path, threads=1)
    assert engine.path == tiny_path
    assert engine.providers == ("CPUExecutionProvider",)
    assert engine.props["footprints.name"] == "tiny"
    assert (engine.threads, OnnxRuntimeEngine(tiny_path).threads >= 1) == (1, True)


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
def test_other_files_are_refused_with_name_and_size(content, reason, tmp_path):
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
def test_a_provider_that_does_not_start_is_reported(tiny_path, monkeypatch):
    assert "CPUExecutionProvider" in available_providers()
    monkeypatch.setattr(
        engine_module,
        "available_providers",
        lambda: ["CUDAExecutionProvider", "CPUExecutionProvider"],
    )
    with pytest.raises(ModelError, match="does not start"):
        OnnxRuntimeEngine(tiny_path, providers=["CUDAExecutionProvider"])


def test_threads_are_a_whole_number(tiny_path):
    with pytest.raises(ModelError, match=r"threads is 1\.5"):
        OnnxRuntimeEngine(tiny_path, threads=1.5)


def test_a_session_option_that_cannot_be_is_refused(tiny_path):
    with pytest.raises(ModelError, match="refuses the session option ''"):
        OnnxRuntimeEngine(tiny_path, session_options={"": "1"})


def test_threads_must_be_positive(tiny_path):
    with pytest.raises(ModelError, match="threads is 0"):
        OnnxRuntimeEngine(tiny_path, threads=0)


def test_a_plugin_that_is_not_installed_is_named(tiny_path):
    with pytest.raises(fp.ModelError, match="pip install onnxruntime-ep-nothing"):
        fp.load(tiny_path, engine="onnxruntime-ep-nothing")


def test_a_provider_other_than_the_cpu_is_in_the_result(tiny_path, picture):
    others = [name for name in engine_module.available_providers() if not name.startswith("CPU")]
    if not others:
        pytest.skip("this onnxruntime has the CPU provider only")
    model = fp.load(tiny_path, providers=[others[-1], "CPUExecutionProvider"], threads=1)
    assert model.predict(picture).model.runtime.endswith(f", {others[-1]}")


@pytest.fixture
def plugin(monkeypatch):
    """The function that installs a fake plug-in package whose provider has a given name."""

    def install(provider, *, loads=True):
        package = ModuleType("onnxruntime_ep_made")
        package.get_library_path = lambda: "/library/of/the/plug-in"
        package.get_ep_names = lambda: [provider]
        monkeypatch.setitem(sys.modules, "onnxruntime_ep_made", package)
        if loads:
            register = lambda name, library: None  # noqa: ARG005, E731
            monkeypatch.setattr(engine_module.ort, "register_execution_provider_library", register)
        engine_module._registered.cache_clear()

    yield install
    engine_module._registered.cache_clear()


def test_a_plugin_without_a_device_here_is_refused(tiny_path, plugin):
    plugin("MadeExecutionProvider")
    with pytest.raises(
        fp.ModelError, match=r"onnxruntime-ep-made.*offers no device on this machine"
    ):
        fp.load(tiny_path, engine="onnxruntime-ep-made")


def test_a_plugin_that_does_not_load_is_refused(tiny_path, plugin):
    plugin("MadeExecutionProvider", loads=False)
    with pytest.raises(
        fp.ModelError, match="onnxruntime-ep-made cannot be loaded into onnxruntime"
    ):
        fp.load(tiny_path, engine="onnxruntime-ep-made")


def test_a_plugin_runs_and_the_result_says_how_much_of_it(tiny_path, tiny, plugin, picture):
    """onnxruntime's own CPU provider has a device as plug-ins have: it stands in for one."""
    plugin("CPUExecutionProvider")
    model = fp.load(tiny_path, engine="onnxruntime-ep-made", threads=1)
    prediction = model.predict(picture)
    np.testing.assert_array_equal(prediction.ground, tiny.predict(picture).ground)
    described = prediction.model.runtime
    assert described.startswith(f"onnxruntime {ort.__version__}, CPUExecutionProvider ")
    assert described.endswith(" nodes")


def test_a_plugin_that_supports_no_node_is_not_replaced_by_the_cpu(tiny_path, plugin, monkeypatch):
    plugin("CPUExecutionProvider")
    monkeypatch.setattr(ort.InferenceSession, "get_provider_graph_assignment_info", lambda _: [])
    with pytest.raises(fp.ModelError, match="supports none of the nodes"):
        fp.load(tiny_path, engine="onnxruntime-ep-made")
