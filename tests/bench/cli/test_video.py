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


@pytest.mark.usefixtures("a_tenth")
def test_the_video_is_repeated_until_it_is_long_enough(video, green_is_ground, tmp_path):
    out = tmp_path / "video.json"
    options = ["--model", str(green_is_ground), "--threads", "1", "--length", "412"]
    result = CliRunner().invoke(app, ["video", str(video), *options, "-o", str(out)])
    assert result.exit_code == 0, result.output
    found = json.loads(out.read_text())
    assert (found["frames"], found["size"]) == (40, [32, 64])
    assert found["early_mb"] > 0
    assert "## Video: 40 frames of 64 x 32" in result.stdout
    rounds = {kind: np.array(fps) for kind, fps in found["fps"].items()}
    assert {fps.shape for fps in rounds.values()} == {(4,)}
    for option in ("--smooth", "--panel", "--format overlay,json"):
        fps = rounds[f"fp-infer VIDEO {option}"]
        others = [rounds[kind] for kind in list(rounds)[:3]]
        shares = " | ".join(f"{np.median(fps / other):.2f}" for other in others)
        row = f"| fp-infer VIDEO {option} | {np.median(fps):.1f} | {shares} |"
        assert row in result.stdout


def test_a_video_that_is_missing_is_named(tmp_path):
    result = CliRunner().invoke(app, ["video", str(tmp_path / "none.mp4")])
    assert result.exit_code == 2
    assert "none.mp4" in result.stderr
