"""Conversions: the file runs anywhere, gives the checkpoint's maps, or is not there at all."""

import json
import shutil
from pathlib import Path

import numpy as np
import onnx
import onnxruntime as ort
import pytest
import torch
from onnx import TensorProto, numpy_helper
from PIL import Image

import footprints_edge
from footprints_edge.errors import ModelError
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import ExportError, VerificationError
from footprints_edge_export.report import report_path
from footprints_edge_export.verification import parity
from footprints_edge_models.networks.channels import raw_to_maps
from footprints_edge_models.networks.checkpoint import (
    FOCAL_PX_KEY,
    file_sha256,
    load_weights,
    read_checkpoint,
)
from footprints_edge_models.networks.reference import ReferenceNetwork


def plain_session(path, optimised=None):
    """A session of onnxruntime alone, as any other program would make one."""
    options = ort.SessionOptions()
    options.log_severity_level = 4
    options.intra_op_num_threads = 1
    if optimised:
        options.optimized_model_filepath = str(optimised)
    return ort.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


def plain_maps(path, image):
    return plain_session(path).run(["maps"], {"image": image})[0]


def torch_maps(network, image):
    x = torch.from_numpy(image.copy()).permute(0, 3, 1, 2).float() / 255
    with torch.no_grad():
        return raw_to_maps(network(x)).numpy()


def noise(height, width, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (1, height, width, 3), dtype=np.uint8)


def network_input(photo, size):
    picture = Image.open(photo).convert("RGB").resize(size[::-1], Image.Resampling.LANCZOS)
    return np.asarray(picture)[None]


@pytest.fixture(scope="module")
def reference_fp32(reference_checkpoint, conversion, tmp_path_factory):
    path = tmp_path_factory.mktemp("reference") / "reference.onnx"
    report = convert(reference_checkpoint, path, conversion("reference"), overwrite=False)
    return path, report


def test_the_reference_file_gives_the_published_maps(reference_fp32, reference_fixture):
    path, _ = reference_fp32
    maps = plain_maps(path, reference_fixture["image"][None])
    assert maps.shape == (1, 4, 96, 128)
    assert maps.dtype == np.float32
    np.testing.assert_allclose(maps, reference_fixture["maps"], rtol=0, atol=1e-4)


@pytest.mark.parametrize("size", [(160, 96), (64, 224)])
def test_the_reference_file_gives_torch_s_maps_at_other_sizes(
    reference_fp32, reference_checkpoint, size
):
    path, _ = reference_fp32
    network = ReferenceNetwork().eval()
    load_weights(network, read_checkpoint(reference_checkpoint), "reference")
    image = noise(*size)
    np.testing.assert_allclose(
        plain_maps(path, image), torch_maps(network, image), rtol=0, atol=1e-4
    )


def test_the_reference_file_says_what_it_is(reference_fp32, reference_checkpoint):
    path, _ = reference_fp32
    metadata = footprints_edge.load(path, threads=1).metadata
    assert metadata.architecture == "reference"
    assert metadata.focal_px is None  # its depths are as trained
    assert "non-commercial" in metadata.licence
    assert metadata.source_sha256 == file_sha256(reference_checkpoint)


@pytest.mark.parametrize("size", [(96, 128), (160, 96), (32, 256), (32, 32)])
def test_the_edge_file_gives_torch_s_maps_at_any_size(edge_fp32, edge_network, size):
    path, _ = edge_fp32
    image = noise(*size)
    expected = torch_maps(edge_network, image)
    assert expected.std(axis=(2, 3)).min() > 1e-3  # maps that vary, or else nothing is shown
    np.testing.assert_allclose(plain_maps(path, image), expected, rtol=0, atol=1e-4)


def test_the_edge_file_of_a_fixed_size_takes_that_size_only(edge_fixed, edge_network):
    path, _ = edge_fixed
    (node,) = plain_session(path).get_inputs()
    assert node.shape == [1, 64, 96, 3]
    image = noise(64, 96)
    expected = torch_maps(edge_network, image)
    np.testing.assert_allclose(plain_maps(path, image), expected, rtol=0, atol=1e-4)
    with pytest.raises(Exception, match=r"(?i)dimension"):
        plain_maps(path, noise(96, 128))
    assert footprints_edge.load(path, threads=1).engine.input_size == (64, 96)


def test_the_files_keep_the_contract(edge_fp32):
    path, _ = edge_fp32
    session = plain_session(path)
    (given,), (gives,) = session.get_inputs(), session.get_outputs()
    assert (given.name, given.type, given.shape) == ("image", "tensor(uint8)", [1, "H", "W", 3])
    assert (gives.name, gives.type, gives.shape[:2]) == ("maps", "tensor(float)", [1, 4])
    model = onnx.load(path)
    assert [opset.domain for opset in model.opset_import] == [""]
    assert model.opset_import[0].version >= 18


def test_files_are_of_the_oldest_format_that_has_their_operators(edge_fixed, mobile, half):
    for path, _ in (edge_fixed, mobile, half):
        model = onnx.load(path)
        assert model.ir_version == 8
        assert [opset.version for opset in model.opset_import] == [18]


def test_weights_may_be_for_another_camera_than_the_architectures(
    edge_checkpoint, conversion, tmp_path
):
    wanted = conversion(focal_px=312.5)
    convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    metadata = footprints_edge.load(tmp_path / "a.onnx", threads=1).metadata
    assert metadata.focal_px == 312.5


def test_the_camera_is_the_one_that_the_weights_state(edge_checkpoint, conversion, tmp_path):
    weights = read_checkpoint(edge_checkpoint)
    torch.save(weights | {FOCAL_PX_KEY: torch.tensor(250.0)}, tmp_path / "a.pt")
    convert(tmp_path / "a.pt", tmp_path / "a.onnx", conversion(), overwrite=False)
    assert footprints_edge.load(tmp_path / "a.onnx", threads=1).metadata.focal_px == 250


def test_the_metadata_is_what_was_asked_for(edge_checkpoint, conversion, tmp_path):
    wanted = conversion(name="mine", licence="Apache-2.0", training="two photos")
    convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    metadata = footprints_edge.load(tmp_path / "a.onnx", threads=1).metadata
    assert (metadata.name, metadata.licence) == ("mine", "Apache-2.0")
    assert (metadata.architecture, metadata.precision) == ("edge", "fp32")
    assert metadata.training == "two photos"
    assert metadata.depth_range_m == (0.1, 100)
    assert metadata.focal_px == 400
    assert metadata.resize == "hamming"
    assert metadata.source_sha256 == file_sha256(edge_checkpoint)
    assert metadata.producer == f"footprints-edge {footprints_edge.__version__}"


def test_the_report_lies_beside_the_file(edge_fp32):
    path, _ = edge_fp32
    assert sorted(p.name for p in path.parent.iterdir()) == ["edge.onnx", "edge.onnx.json"]
    report = json.loads((path.parent / "edge.onnx.json").read_text())
    assert report_path(path) == path.parent / "edge.onnx.json"
    assert report["model"] == {
        "file": "edge.onnx",
        "bytes": path.stat().st_size,
        "sha256": file_sha256(path),
    }
    assert report["metadata"]["architecture"] == "edge"
    assert set(report["torch_to_fp32"]) == {
        "visible_ground",
        "ground",
        "visible_depth",
        "ground_depth",
    }
    assert all(0 <= value <= 1e-4 for value in report["torch_to_fp32"].values())
    sizes = report["parity_sizes"]
    assert any(h > w for h, w in sizes)
    assert any(h < w for h, w in sizes)
    assert report["fp32_to_int8"] is None
    assert report["target"] is None
    assert report["calibration_photos"] == 0
    assert report["versions"]["onnxruntime"] == ort.__version__
    assert set(report["versions"]) == {"footprints-edge", "torch", "onnx", "onnxruntime"}


def initialisers(model):
    return {tensor.name: numpy_helper.to_array(tensor) for tensor in model.graph.initializer}


def test_an_int8_file_is_close_to_the_float_one(edge_int8, edge_fixed, photos, request):
    path, report, target = edge_int8
    if target == "x86-vnni":
        request.getfixturevalue("exact_int8")
    for photo in sorted(photos.iterdir()):
        image = network_input(photo, (64, 96))
        expected = plain_maps(edge_fixed[0], image)
        off = np.abs(plain_maps(path, image) - expected)
        # Measured: a fifth of how much the maps vary over the picture; a broken graph: about all.
        assert (off.mean(axis=(2, 3)) < 0.45 * expected.std(axis=(2, 3))).all()
        assert off.max() < 0.25  # single pixels: some processors saturate
    assert 0 < max(report.fp32_to_int8["max_abs"].values()) < 0.5


def test_an_int8_file_is_smaller_and_says_what_it_is(edge_int8, edge_fixed):
    path, report, target = edge_int8
    assert path.stat().st_size < 0.4 * edge_fixed[0].stat().st_size
    metadata = footprints_edge.load(path, threads=1).metadata
    assert (metadata.precision, metadata.name) == ("int8", "small")
    written = json.loads(report_path(path).read_text())
    assert written["target"] == report.target == target
    assert written["calibration_photos"] == 8  # one in five is held out, to judge it
    assert written["fp32_to_int8"]["photos"] == 2
    assert written["metadata"]["precision"] == "int8"
    assert written["model"]["sha256"] == file_sha256(path)


def test_an_int8_file_is_made_of_the_kind_of_numbers_its_cpu_wants(edge_int8):
    path, _, target = edge_int8
    model = onnx.load(path)
    constants = initialisers(model)
    activations = {
        constants[node.input[2]].dtype
        for node in model.graph.node
        if node.op_type == "QuantizeLinear"
    }
    assert activations == {np.dtype(np.int8 if target == "arm64" else np.uint8)}
    kernels = [value for value in constants.values() if value.dtype == np.int8 and value.ndim == 4]
    assert len(kernels) > 40
    largest = max(np.abs(kernel.astype(int)).max() for kernel in kernels)
    assert largest <= 64 if target == "x86-avx2" else 100 < largest <= 127


def test_an_int8_file_keeps_its_head_in_float(edge_int8):
    path, _, _ = edge_int8
    model = onnx.load(path)
    makers = {name: node for node in model.graph.node for name in node.output}
    constants = initialisers(model)
    waiting, heads = [model.graph.output[0].name], []
    while waiting:
        node = makers.get(waiting.pop())
        if node is None:
            continue
        if node.op_type == "Conv":
            heads.append(node)
            continue
        assert node.op_type not in {"QuantizeLinear", "DequantizeLinear"}, node.name
        waiting += node.input
    assert heads
    for head in heads:
        assert constants[head.input[1]].dtype == np.float32


def test_onnxruntime_fuses_an_int8_file_into_integers(make_int8, tmp_path):
    path, _ = make_int8("x86-vnni")
    plain_session(path, tmp_path / "optimised.onnx")
    nodes = onnx.load(tmp_path / "optimised.onnx").graph.node
    float_convolutions = [n for n in nodes if n.op_type in {"Conv", "FusedConv"}]
    assert len(float_convolutions) == 1  # the head
    assert len([n for n in nodes if n.op_type == "QLinearConv"]) > 40

    # The bytes themselves feed the first convolution: no float picture on the way.
    current, path_of_bytes = "image", []
    while True:
        (node,) = [n for n in nodes if current in n.input]
        path_of_bytes.append(node.op_type)
        current = node.output[0]
        if node.op_type not in {"Transpose", "Identity"}:
            break
    assert path_of_bytes[-1] == "QLinearConv"


@pytest.fixture(params=["fp32", "int8"])
def any_file(request, edge_fp32, make_int8):
    return (edge_fp32 if request.param == "fp32" else make_int8("x86-vnni"))[0]


def test_a_file_is_whole_and_standard(any_file, tmp_path):
    alone = tmp_path / "alone.onnx"
    shutil.copyfile(any_file, alone)  # nothing else beside it
    assert plain_maps(alone, noise(64, 96)).shape == (1, 4, 64, 96)
    model = onnx.load(alone, load_external_data=False)
    assert {node.domain for node in model.graph.node} == {""}
    assert not model.functions
    assert not any(t.data_location == TensorProto.EXTERNAL for t in model.graph.initializer)


def test_a_file_says_nothing_of_the_machine_that_made_it(any_file):
    data = any_file.read_bytes()
    checkout = Path(__file__).resolve().parents[2]
    for text in (checkout, "site-packages", any_file.parent, any_file.parent.parent, Path.home()):
        assert str(text).encode() not in data, text
    assert b"stack_trace" not in data
    assert b"footprints.name" in data  # the search finds what is there


def test_a_refused_result_leaves_nothing_behind(edge_checkpoint, conversion, tmp_path, monkeypatch):
    monkeypatch.setattr(parity, "TOLERANCE", 0)
    with pytest.raises(VerificationError, match=r"differs from torch.*no file was written"):
        convert(edge_checkpoint, tmp_path / "a.onnx", conversion(), overwrite=False)
    assert list(tmp_path.iterdir()) == []


def test_a_refused_result_keeps_what_was_there(edge_checkpoint, conversion, tmp_path, monkeypatch):
    (tmp_path / "a.onnx").write_text("old")
    monkeypatch.setattr(parity, "TOLERANCE", 0)
    with pytest.raises(VerificationError):
        convert(edge_checkpoint, tmp_path / "a.onnx", conversion(), overwrite=True)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.onnx", "old")]


@pytest.mark.parametrize("name", ["a.onnx", "a.onnx.json"])
def test_what_is_there_is_kept_unless_it_may_be_replaced(
    edge_checkpoint, conversion, tmp_path, name
):
    (tmp_path / name).write_text("old")
    wanted = conversion(size=(64, 96))
    with pytest.raises(ExportError, match=rf"{name} exists; --overwrite"):
        convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [(name, "old")]
    convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=True)
    footprints_edge.load(tmp_path / "a.onnx", threads=1)
    assert json.loads((tmp_path / "a.onnx.json").read_text())["model"]["file"] == "a.onnx"


def test_the_checkpoint_is_never_replaced(edge_checkpoint, conversion, tmp_path):
    shutil.copyfile(edge_checkpoint, tmp_path / "a.onnx")
    with pytest.raises(ExportError, match="checkpoint itself"):
        convert(tmp_path / "a.onnx", tmp_path / "a.onnx", conversion(), overwrite=True)
    assert file_sha256(tmp_path / "a.onnx") == file_sha256(edge_checkpoint)


def few_photos(folder, count):
    folder.mkdir()
    for index in range(count):
        Image.fromarray(noise(40, 60, index)[0]).save(folder / f"{index}.png")
    return folder


@pytest.mark.parametrize(
    ("options", "output", "says"),
    [
        ({"precision": "int8"}, "a.onnx", "--calibration"),
        ({"precision": "int8", "calibration": "few"}, "a.onnx", "few: 4 photos, at least 5"),
        ({"precision": "int8", "calibration": "gone"}, "a.onnx", "gone: no such folder"),
        ({"size": (100, 128)}, "a.onnx", "multiples of 32"),
        ({"size": (0, 128)}, "a.onnx", "multiples of 32"),
        ({}, "a.pth", r"a\.pth: a model file ends in \.onnx"),
        ({}, "gone/a.onnx", "gone: no such folder to write to"),
    ],
)
def test_options_that_make_no_file(edge_checkpoint, conversion, tmp_path, options, output, says):
    few_photos(tmp_path / "few", 4)
    if "calibration" in options:
        options = options | {"calibration": (tmp_path / options["calibration"],)}
    with pytest.raises(ExportError, match=says):
        convert(edge_checkpoint, tmp_path / output, conversion(**options), overwrite=False)
    assert [p.name for p in tmp_path.iterdir()] == ["few"]


def test_a_size_too_small_for_the_reference_network_is_refused_in_words(conversion, tmp_path):
    """Reflection padding needs two pixels at the deepest scale: sides of 64 at least."""
    torch.save(ReferenceNetwork().state_dict(), tmp_path / "model.pth")
    with pytest.raises(ExportError, match="64"):
        convert(
            tmp_path / "model.pth",
            tmp_path / "a.onnx",
            conversion("reference", size=(32, 64)),
            overwrite=False,
        )


def test_a_checkpoint_of_another_network_is_refused(edge_checkpoint, conversion, tmp_path):
    with pytest.raises(ModelError, match=r"not a checkpoint of ReferenceNetwork: 484 missing"):
        convert(edge_checkpoint, tmp_path / "a.onnx", conversion("reference"), overwrite=False)
    assert list(tmp_path.iterdir()) == []


def int8_of(folder, conversion):
    return conversion(size=(64, 96), precision="int8", calibration=(folder,))


def test_photos_of_which_none_can_be_read_are_too_few(edge_checkpoint, conversion, tmp_path):
    folder = tmp_path / "photos"
    folder.mkdir()
    for index in range(10):
        (folder / f"{index}.png").write_text("not a picture")
    with pytest.raises(ExportError, match="photos"):
        convert(edge_checkpoint, tmp_path / "a.onnx", int8_of(folder, conversion), overwrite=False)
    assert [p.name for p in tmp_path.iterdir()] == ["photos"]


def test_held_out_photos_of_which_none_can_be_read_judge_nothing(
    edge_checkpoint, conversion, tmp_path
):
    """Without this, the report would praise a file that nobody looked at."""
    folder = few_photos(tmp_path / "photos", 5)
    (folder / "4.png").write_text("not a picture")  # the fifth is the one held out
    with pytest.raises(ExportError, match="photos"):
        convert(edge_checkpoint, tmp_path / "a.onnx", int8_of(folder, conversion), overwrite=False)
