"""`fp-bench video` on a short synthetic clip."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge_bench.cli import app
from footprints_edge_bench.temporal import video_throughput

cv2 = pytest.importorskip("cv2", reason="videos are read with OpenCV")


@pytest.fixture
def video(tmp_path):
    """Twelve frames of 32 x 64, ever greener."""
    path = tmp_path / "walk.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 15, (64, 32))
    for level in range(12):
        writer.write(np.full((32, 64, 3), (0, 20 * level, 0), np.uint8))
    writer.release()
    return path


@pytest.fixture
def a_tenth(monkeypatch):
    """A tenth of the frames that are asked for is measured."""
    measure_video = video_throughput.measure_video

    def measure(path, model, threads, frames):
        return measure_video(path, model, threads, frames // 10)

    monkeypatch.setattr(video_throughput, "measure_video", measure)
    monkeypatch.setattr(video_throughput, "SETTLED_FRAMES", video_throughput.SETTLED_FRAMES // 10)


@pytest.mark.usefixtures("a_tenth")
def test_the_video_is_repeated_until_it_is_long_enough(video, green_is_ground, tmp_path):
    out = tmp_path / "video.json"
    options = ["--model", str(green_is_ground), "--threads", "1", "--length", "410"]
    result = CliRunner().invoke(app, ["video", str(video), *options, "-o", str(out)])
    assert result.exit_code == 0, result.output
    found = json.loads(out.read_text())
    assert (found["frames"], found["size"]) == (41, [32, 64])
    assert found["share"] == pytest.approx(found["pipeline_fps"] / found["inference_fps"])
    assert min(found["inference_at_once_fps"], found["smoothed_fps"], found["early_mb"]) > 0
    assert "## Video: 41 frames of 64 x 32" in result.stdout
    for option in ("smooth", "panel"):
        fps = found["smoothed_fps" if option == "smooth" else "panel_fps"]
        change = fps / found["pipeline_fps"] - 1
        assert f"| fp-infer VIDEO --{option} | {fps:.1f} ({change:+.0%}) |" in result.stdout


def test_a_video_that_is_missing_is_named(tmp_path):
    result = CliRunner().invoke(app, ["video", str(tmp_path / "none.mp4")])
    assert result.exit_code == 2
    assert "none.mp4" in result.stderr
