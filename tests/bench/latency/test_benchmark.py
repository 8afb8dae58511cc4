"""The latency benchmark, small, from end to end."""

import importlib.util
import json
from dataclasses import asdict

import onnx
import pytest
from onnx import TensorProto, helper
from PIL import Image

from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_bench.engines.backend import (
    BackendSetting,
)
from footprints_edge_bench.latency.backends import select_backends
from footprints_edge_bench.latency.benchmark import time_backends
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.plot import draw
from footprints_edge_bench.latency.tables import as_json, as_markdown
from footprints_edge_bench.model_files.model_cache import ModelCache, part_of
from footprints_edge_models.networks import reference

pytestmark = pytest.mark.usefixtures("graphs_once")

SIZE = (64, 96)

HAS_OPENVINO = importlib.util.find_spec("openvino") is not None


@pytest.fixture(scope="module", autouse=True)
def _shallow_reference():
    """The reference network with one block a layer: files and rows as of the deep one, sooner."""
    layer = reference._layer

    def shallow(inputs, outputs, *, stride, **_):
        return layer(inputs, outputs, blocks=1, stride=stride)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference, "_layer", shallow)
        yield


@pytest.fixture(scope="module")
def measured(once):
    """The model files, and the report: the reference network, tiny, in all engines that are there;
    and an edge row that has no checkpoint to be made from."""

    def make(folder):
        files = ModelCache(folder, folder / "no.pt")
        names = ["reference 64x96 onnxruntime", "torch fp32", "openvino fp32", "openvino int8"]
        rows = [
            row
            for row in select_backends(names, sizes=[SIZE])
            if row.precision != "int8-nncf"
            and not part_of(row.precision)
            and (row.network == "reference" or row.engine == "torch")
        ]
        return files, time_backends(rows, BackendSetting(files, 1), machine(), trials=2)

    return once("latency", make)


@pytest.fixture(scope="module")
def files(measured):
    return measured[0]


@pytest.fixture(scope="module")
def report(measured):
    return measured[1]


def row_of(report, name):
    return next(row for row in report.rows if row.name == name)


@pytest.fixture
def parts_of_the_whole(files, monkeypatch):
    """Parts are converted from the whole files: their channels, without torch's exporter."""

    def convert(checkpoint, output, conversion, *, overwrite):
        assert (conversion.scale, checkpoint.is_file(), overwrite) == (1, True, False)
        channels = list(OUTPUTS[conversion.outputs])
        model = onnx.load(files.onnx(conversion.architecture, SIZE, conversion.precision))
        (last,) = (node for node in model.graph.node if "maps" in node.output)
        last.output[:] = ["all_maps"]
        indices = helper.make_tensor("channels", TensorProto.INT64, [len(channels)], channels)
        model.graph.initializer.append(indices)
        gather = helper.make_node("Gather", ["all_maps", "channels"], ["maps"], axis=1)
        model.graph.node.append(gather)
        model.graph.output[0].type.tensor_type.shape.dim[1].dim_value = len(channels)
        props = {prop.key: prop.value for prop in model.metadata_props}
        helper.set_model_props(model, props | {"footprints.outputs": conversion.outputs})
        onnx.save(model, output)

    monkeypatch.setattr("footprints_edge_export.convert.convert", convert)


@pytest.mark.usefixtures("parts_of_the_whole")
def test_a_part_is_compared_with_float32_of_the_same_part(files):
    rows = select_backends(["onnxruntime int8-depths"], sizes=[SIZE])
    assert [row.network for row in rows] == ["edge", "reference"]
    report = time_backends(rows, BackendSetting(files, 1), machine(), trials=2)
    edge, reference = report.rows
    assert "no such checkpoint" in edge.reason
    assert reference.reason is None
    assert reference.accuracy["ground_iou"] is None
    assert 0 < reference.accuracy["visible_depth_abs_rel"] < 0.5
    (line,) = [
        line for line in as_markdown(report, [], None).splitlines() if "int8-depths |" in line
    ]
    assert line.split("|")[-3].strip() == "-"
    assert line.split("|")[-2].strip().endswith("%")


def test_rows_that_ran_say_what_in(report):
    int8 = row_of(report, "reference 64x96 onnxruntime int8")
    fp32 = row_of(report, "reference 64x96 onnxruntime fp32")
    torch = row_of(report, "reference 64x96 torch fp32")
    assert int8.precision.startswith("int8 (")
    assert fp32.precision.startswith("float32 (")
    assert torch.precision.startswith("float32 (")
    assert int8.file_bytes < 0.3 * fp32.file_bytes
    assert torch.file_bytes is None
    for row in (int8, fp32, torch):
        assert len(row.times_ms) == row.summary.n == 2
        assert row.summary.min_ms == min(row.times_ms) > 0


def test_accuracy_stands_beside_each_row(report):
    fp32 = row_of(report, "reference 64x96 onnxruntime fp32").accuracy
    torch = row_of(report, "reference 64x96 torch fp32").accuracy
    int8 = row_of(report, "reference 64x96 onnxruntime int8").accuracy
    stock = row_of(report, "reference 64x96 onnxruntime fp32-stock").accuracy
    assert max(stock["max_abs"].values()) == 0
    assert max(fp32["max_abs"].values()) < 1e-4
    assert max(torch["max_abs"].values()) < 1e-4  # what a conversion promises
    assert 0 < int8["visible_depth_abs_rel"] < 0.5  # random weights magnify what int8 costs


@pytest.mark.skipif(not HAS_OPENVINO, reason="the extra peers is not installed")
def test_openvino_runs_in_the_precision_that_is_asked_for(report):
    fp32 = row_of(report, "reference 64x96 openvino fp32")
    assert fp32.precision.startswith("float32 (")
    assert max(fp32.accuracy["max_abs"].values()) < 1e-3
    assert row_of(report, "reference 64x96 openvino int8").reason is None


def test_a_row_that_cannot_run_says_why(report):
    missing = row_of(report, "edge 256x448 torch fp32")
    assert "no.pt" in missing.reason
    assert "--edge-checkpoint" in missing.reason
    assert missing.summary is None
    assert missing.reason in as_markdown(report, (), None)


def test_every_two_rows_of_a_size_have_a_ratio(report):
    names = [row.name for row in report.rows if row.backend.size == SIZE and row.summary]
    for name in names:
        assert set(report.ratios[name]) == set(names) - {name}
    first, second = names[:2]
    there, back = report.ratios[first][second], report.ratios[second][first]
    assert there.value * back.value == pytest.approx(1)
    assert there.low <= there.value <= there.high


def test_the_table_is_against_torch(report):
    text = as_markdown(report, (), None)
    assert "Speed-up over: reference 64x96 torch fp32." in text
    assert "random weights" in text
    assert report.machine.cpu in text


def test_json_holds_every_time(report):
    content = json.loads(as_json(report, (), None))
    assert [row["times_ms"] for row in content["rows"]] == [list(r.times_ms) for r in report.rows]
    assert content["machine"] == json.loads(json.dumps(asdict(report.machine)))
    assert content["threads"] == 1


def test_the_plot_shows_something(report, tmp_path):
    draw(report, tmp_path / "plot.png")
    with Image.open(tmp_path / "plot.png") as image:
        assert image.width > 300
        assert len(image.convert("RGB").getcolors(maxcolors=1 << 24)) > 50


def test_converted_files_are_made_once(report, files):
    assert report.rows
    before = {path: path.stat().st_mtime_ns for path in files.folder.rglob("model.onnx")}
    whole = [path for path in before if "-depths-" not in path.parent.name]
    assert len(whole) == 4  # int8 and fp32, ours and stock
    for path in before:
        precision = "-".join(path.parent.name.split("-")[2:-1])
        assert files.onnx("reference", SIZE, precision) == path
    assert {path: path.stat().st_mtime_ns for path in before} == before
