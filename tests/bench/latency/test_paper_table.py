"""The paper's speed table: quoted as it stands there, ours measured."""

import json
import re
from dataclasses import replace

import pytest

from footprints_edge_bench.engines.backend import BackendSetting
from footprints_edge_bench.latency import paper_table as module
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.paper_table import PAPER, speed_table
from footprints_edge_bench.latency.peer_rows import PEERS, PeerRow
from footprints_edge_bench.model_files.model_cache import ModelCache


def test_the_quoted_rows_are_the_papers(shared):
    text = (shared / "paper" / "footprints.tex").read_text()
    table = text[text.index(r"\textbf{Preprocessing (s)}") :]
    table = table[: table.index(r"\end{tabular}")]
    rows = [line for line in table.splitlines() if line.count("&") == 2]
    printed = []
    for row in rows:
        _, *cells = re.sub(r"\\textbf|\\\\|[{}\s]", "", row).split("&")
        printed.append(tuple(None if cell == "-" else float(cell) for cell in cells))
    assert len(printed) == 4
    assert [(row.preprocessing_s, row.inference_s) for row in PAPER] == printed


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """Two rows of one preset: one that runs, and one whose checkpoint is not there."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "OURS", (("edge", "onnxruntime", "int8"), ("edge", "torch", "fp32")))
        setting = BackendSetting(ModelCache(folder, folder / "no.pt"), 1)
        return speed_table(setting, machine(), 2, ["handheld"], [])


def test_ours_stand_below_the_papers_and_apart(measured):
    lines = [line for line in measured.as_markdown().splitlines() if line.startswith("|")]
    _, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert [row[2] for row in rows] == ["by the paper"] * 4 + ["here"]
    assert [row[3:] for row in rows[:4]] == [
        ["43", "66"],
        ["-", "0.417"],
        ["-", "0.520"],
        ["-", "0.074"],
    ]
    ours = rows[4]
    assert "int8" in ours[0]
    assert "256x448" in ours[1]
    assert float(ours[3]) > 0
    assert float(ours[4]) > 0


def test_a_row_that_cannot_run_says_why(measured):
    _, missing = measured.rows
    assert missing.inference_s is None
    assert "no.pt" in missing.reason
    assert missing.reason in measured.as_markdown()


def test_json_holds_the_papers_rows_and_ours(measured):
    found = json.loads(measured.as_json())
    assert [row["inference_s"] for row in found["paper"]] == [66, 0.417, 0.52, 0.074]
    assert found["rows"][0]["inference_s"] == measured.rows[0].inference_s
    assert found["machine"]["usable_cores"] >= 1


def test_a_peer_stands_beside_the_papers_figure(measured):
    peers = (
        PeerRow("Voxels (SSCNet)", "torch", "the room's axes", None, 2.0, 3.45),
        PeerRow("Bounding box (Qi et al.)", "torch", "3D suppression", "needs torch"),
    )
    text = replace(measured, peers=peers).as_markdown()
    (row,) = [line for line in text.splitlines() if line.startswith("| Voxels (SSCNet), in")]
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    ours_s = measured.rows[0].inference_s
    assert cells[1:] == ["2.000", "3.450", "109", "0.05", f"{3.45 / ours_s:.0f}"]
    assert "- Voxels (SSCNet): the room's axes." in text
    assert "- Bounding box (Qi et al.), torch: needs torch" in text


def test_every_peer_is_a_row_of_the_papers_table():
    methods = {row.method for row in PAPER}
    assert {make().method for make in PEERS} == methods - {"Footprints, the paper's"}
