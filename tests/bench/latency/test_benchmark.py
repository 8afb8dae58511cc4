"""The latency benchmark, small, from end to end; and what it says of rows that cannot run."""

import importlib.util
import json
import subprocess
import sys
import time
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from footprints_edge.model import load
from footprints_edge_bench.engines import open_backend as opening
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
    Spinning,
    describe_precisions,
)
from footprints_edge_bench.engines.open_backend import open_backend
from footprints_edge_bench.latency.benchmark import (
    LatencyError,
    run,
    select_backends,
    synthetic_images,
)
from footprints_edge_bench.latency.cold_start import ColdStartError, cold_start
from footprints_edge_bench.latency.end_to_end import end_to_end
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.plot import draw
from footprints_edge_bench.latency.tables import as_json, markdown
from footprints_edge_bench.model_files.model_cache import ModelCache, part_of
from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg, synthetic_photo

SIZE = (64, 96)
HAS_OPENVINO = importlib.util.find_spec("openvino") is not None


def command(*arguments, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "footprints_edge_bench.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
        cwd=cwd,
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    return ModelCache(folder, folder / "no.pt")


@pytest.fixture(scope="module")
def report(files):
    """The reference network, tiny, in all engines that are there; and an edge row that has no
    checkpoint to be made from."""
    rows = [
        *select_backends(
            ["reference 64x96 onnxruntime", "torch fp32", "openvino fp32", "openvino int8"],
            sizes=[SIZE],
        )
    ]
    rows = [row for row in rows if row.precision != "int8-nncf" and not part_of(row.precision)]
    return run(rows, BackendSetting(files, 1), machine(), trials=2)


def row_of(report, name):
    return next(row for row in report.rows if row.name == name)


def test_a_part_is_compared_with_float32_of_the_same_part(tmp_path):
    rows = select_backends(["onnxruntime int8-depths"], sizes=[SIZE])
    assert [row.network for row in rows] == ["edge", "reference"]
    files = ModelCache(tmp_path, tmp_path / "no.pt")
    report = run(rows, BackendSetting(files, 1), machine(), trials=2)
    edge, reference = report.rows
    assert "no such checkpoint" in edge.reason
    assert reference.reason is None
    assert reference.accuracy["ground_iou"] is None
    assert 0 < reference.accuracy["visible_depth_abs_rel"] < 0.5
    (line,) = [line for line in markdown(report, [], None).splitlines() if "int8-depths |" in line]
    assert line.split("|")[-3].strip() == "-"
    assert line.split("|")[-2].strip().endswith("%")


def test_the_edge_network_has_no_coarser_heads():
    names = [row.name for row in select_backends(["-scale"], sizes=[SIZE])]
    assert names and all(name.startswith("reference") for name in names)


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
    assert missing.reason in markdown(report, (), None)


def test_every_two_rows_of_a_size_have_a_ratio(report):
    names = [row.name for row in report.rows if row.backend.size == SIZE and row.summary]
    for name in names:
        assert set(report.ratios[name]) == set(names) - {name}
    first, second = names[:2]
    there, back = report.ratios[first][second], report.ratios[second][first]
    assert there.value * back.value == pytest.approx(1)
    assert there.low <= there.value <= there.high


def test_the_table_is_against_torch(report):
    text = markdown(report, (), None)
    assert "Times as fast as: reference 64x96 torch fp32." in text
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
    assert len(before) == 4  # int8 and fp32, ours and stock
    for path in before:
        precision = "-".join(path.parent.name.split("-")[2:-1])
        assert files.onnx("reference", SIZE, precision) == path
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_a_failed_making_leaves_nothing(tmp_path):
    def fail(folder):
        (folder / "half").write_text("half")
        raise RuntimeError("no")

    files = ModelCache(tmp_path)
    with pytest.raises(RuntimeError, match="no"):
        files.kept("thing", {"a": 1}, fail)
    assert list(tmp_path.iterdir()) == []
    made = files.kept("thing", {"a": 1}, lambda folder: (folder / "whole").write_text("1"))
    assert files.kept("thing", {"a": 1}, fail) == made
    other = files.kept("thing", {"a": 2}, lambda folder: (folder / "whole").write_text("2"))
    assert other != made


@pytest.mark.parametrize("spinning", Spinning)
def test_the_way_of_waiting_changes_no_map(green_is_ground, files, spinning):
    row = Backend(str(green_is_ground), (32, 64), "onnxruntime", "fp32")
    running = open_backend(row, BackendSetting(files, 1, spinning))
    image = synthetic_images((32, 64))[0]
    np.testing.assert_array_equal(running.run(image), load(green_is_ground).engine.run(image))


def test_a_package_that_is_missing_is_named(files, monkeypatch):
    def missing(*_):
        raise ModuleNotFoundError("No module named 'fast_engine'", name="fast_engine")

    monkeypatch.setattr(opening, "import_module", lambda _: SimpleNamespace(open_with=missing))
    row = Backend("edge", (256, 448), "ncnn", "fp32")
    with pytest.raises(BackendError, match=r"fast_engine.*peers"):
        open_backend(row, BackendSetting(files, 1))


def test_maps_that_are_no_numbers_are_refused(files, monkeypatch):
    maps = np.full((1, 4, 256, 448), np.nan, np.float32)

    def broken(*_):
        return LoadedBackend(lambda _: maps, "float32", None)

    monkeypatch.setattr(opening, "import_module", lambda _: SimpleNamespace(open_with=broken))
    with pytest.raises(BackendError, match="not finite"):
        open_backend(Backend("edge", (256, 448), "ncnn", "fp32"), BackendSetting(files, 1))


def test_precisions_are_counted_most_first():
    assert describe_precisions({"float32": 4, "int8": 52}) == "int8 (52 convolutions; float32 4)"
    assert describe_precisions({"float32": 4}) == "float32 (4 convolutions)"


def test_only_takes_rows_by_their_names():
    names = [row.name for row in select_backends(["192x640 openvino"])]
    assert names == [
        "reference 192x640 openvino fp32",
        "reference 192x640 openvino bf16",
        "reference 192x640 openvino int8",
        "reference 192x640 openvino int8-nncf",
    ]
    with pytest.raises(LatencyError, match="fits no row"):
        select_backends(["nonsense"])


def test_made_photos_are_seeded_and_differ():
    np.testing.assert_array_equal(synthetic_photo((48, 64), 1), synthetic_photo((48, 64), 1))
    assert (
        np.abs(synthetic_photo((48, 64), 1).astype(int) - synthetic_photo((48, 64), 2)).mean() > 10
    )
    assert synthetic_jpeg((48, 64))[:2] == b"\xff\xd8"


def test_the_stages_of_the_whole_frame_add_up(green_is_ground):
    (found,) = end_to_end({"green": load(green_is_ground, threads=1)}, 5, (120, 160))
    assert list(found.stages_ms) == [
        "decode",
        "preprocess",
        "inference",
        "postprocess",
        "threshold",
    ]
    assert found.total.n == 5
    assert found.image_size == (120, 160)
    assert sum(found.stages_ms.values()) < 1.5 * found.total.p90_ms


def test_a_cold_start_is_of_fresh_processes(green_is_ground):
    found = cold_start({"green": str(green_is_ground)}, 1, 2)
    assert found.base.n == found.infer.n == 2
    assert found.infer_against_base.value > 1
    assert set(found.steps_ms["green"]) == {"import", "load", "first frame"}
    # Python with numpy and onnxruntime takes tens of MB, a photo of 1.2 million pixels not a GB;
    # this process, with torch in it, takes more.
    assert 30e6 < found.steps_peak_bytes["green"] < 400e6
    assert 30e6 < found.infer_peak_bytes < 1e9
    assert "peak memory" in found.as_markdown()


def test_a_cold_start_that_fails_says_why(tmp_path):
    with pytest.raises(ColdStartError, match=r"none\.onnx"):
        cold_start({"none": str(tmp_path / "none.onnx")}, 1, 1)


@pytest.mark.parametrize("name", ["latency", "table", "roofline"])
def test_help_is_quick_and_complete(name):
    times = []
    for _ in range(3):
        start = time.perf_counter()
        done = command(name, "--help")
        times.append(time.perf_counter() - start)
        assert done.returncode == 0
    assert min(times) < 1.0  # 0.3 s on a machine that does nothing else
    for option in ("--threads", "--trials", "--output", "--cache", "--edge-checkpoint"):
        assert option in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["latency", "--only", "nonsense"], "fits no row"),
        (["latency", "--size", "100x100"], "multiples of 32"),
        (["latency", "--size", "wide"], "HxW"),
        (["table", "--preset", "moon"], "kitti"),
        (["roofline", "--only", "nonsense"], "fits no row"),
        (["latency", "--trials", "1"], "trials"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(tmp_path, arguments, words):
    done = command(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not done.stdout


def test_the_command_writes_its_files_and_fails_for_a_row_of_ours(tmp_path):
    options = ["--trials", 2, "--threads", 1, "--network-only", "--cache", tmp_path / "cache"]
    done = command("latency", "--only", "edge 256x448 onnxruntime", *options, cwd=tmp_path)
    assert done.returncode == 1  # no checkpoint here to make the float row from
    assert "Not run: edge 256x448 onnxruntime fp32" in done.stderr
    assert (tmp_path / "latency/latency.md").read_text() == done.stdout
    assert json.loads((tmp_path / "latency/latency.json").read_text())["trials"] == 2
    assert (tmp_path / "latency/latency.png").stat().st_size > 1000


def test_a_model_file_is_a_row(green_is_ground, tmp_path):
    options = ["--trials", 2, "--threads", 1, "--network-only", "--cache", tmp_path / "cache"]
    done = command("latency", "--only", "green", "--model", green_is_ground, *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"{green_is_ground} 32x64 onnxruntime fp32" in done.stdout
