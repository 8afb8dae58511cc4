"""`fp-infer` on videos and pipes."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from videos import SIZE, indices_of, shade, write_video

from footprints_edge.video.capture import open_video

pytest.importorskip("cv2")


def test_a_video_gives_an_overlay_and_a_line_per_frame(infer, clip):
    result = infer(clip, "--format", "overlay,json", "--every", "2")
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == [f"{clip}.overlay.mp4", f"{clip}.jsonl"]
    assert "10 frames" in result.stderr
    overlay = open_video(f"{clip}.overlay.mp4")
    assert (overlay.fps, overlay.total) == (5, 10)
    first = next(overlay.frames).rgb
    assert first.shape[0] > SIZE[0] and first.shape[1] >= SIZE[1]  # the legend is below
    with clip.with_name("clip.avi.jsonl").open() as file:
        lines = [json.loads(line) for line in file]
    assert [line["frame"] for line in lines] == list(range(0, 20, 2))
    assert [line["time_s"] for line in lines] == pytest.approx([index / 5 for index in range(10)])
    assert set(lines[0]["ground_fraction"]) == {"visible", "hidden", "all"}


def test_results_are_kept_unless_overwrite_is_given(infer, clip):
    assert infer(clip, "--format", "json").exit_code == 0
    lines = clip.with_name("clip.avi.jsonl")
    lines.write_text("mine")
    kept = infer(clip, "--format", "json")
    assert kept.exit_code == 0 and "--overwrite" in kept.stderr
    assert lines.read_text() == "mine"
    assert infer(clip, "--format", "json", "--overwrite").exit_code == 0
    assert len(lines.read_text().splitlines()) == 20


@pytest.mark.parametrize("options", [["--bev"], ["--smooth", "--bev"]])
def test_bev_adds_a_view_beside_the_overlay(infer, clip, options):
    assert infer(clip).exit_code == 0
    plain = next(open_video(f"{clip}.overlay.mp4").frames).rgb
    result = infer(clip, "--overwrite", *options)
    assert result.exit_code == 0, result.output
    wide = next(open_video(f"{clip}.overlay.mp4").frames).rgb
    assert wide.shape[1] > plain.shape[1] >= SIZE[1]
    assert abs(wide.shape[0] - plain.shape[0]) <= 1


@pytest.fixture
def flickering(tmp_path):
    """A still scene whose brightness jumps around the model's threshold from frame to frame."""
    x, y = np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0]))
    texture = 15 * np.sin(x / 5) * np.sin(y / 4) + 10 * np.sin((x + 2 * y) / 9)
    offsets = np.random.default_rng(0).uniform(-9, 9, 24)
    green = np.clip(128 + texture + offsets[:, None, None], 0, 255).astype(np.uint8)
    frames = np.stack([np.full_like(green, 100), green, np.zeros_like(green)], axis=-1)
    return write_video(tmp_path / "flickering.avi", frames)


def flicker_of(clip):
    """Mean change of the visible ground's fraction from frame to frame, once smoothing runs."""
    lines = clip.with_name(f"{clip.name}.jsonl").read_text().splitlines()
    visible = [json.loads(line)["ground_fraction"]["visible"] for line in lines]
    return np.abs(np.diff(visible[4:])).mean()


def test_smooth_reduces_flicker(infer, flickering):
    assert infer(flickering, "--format", "json").exit_code == 0
    plain = flicker_of(flickering)
    assert plain > 0.05
    assert infer(flickering, "--format", "json", "--smooth", "--overwrite").exit_code == 0
    assert flicker_of(flickering) < 0.5 * plain


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["{clip}", "--format", "npz"], 1, "videos do not support the format npz"),
        (["{clip}", "--path", "1,1", "2,2"], 2, "--path works on pictures only"),
        (["{clip}", "--raw", "64x48"], 2, "give - and nothing else"),
        (["-", "--raw", "64"], 2, "640x360"),
        (["picture.png", "--smooth"], 2, "for videos"),
        (["nowhere.mp4"], 1, "nowhere.mp4: no such file"),
        (["{clip}", "--max-fps", "0"], 2, "positive"),
    ],
)
def test_errors_are_explained(infer, clip, arguments, code, says):
    result = infer(*(argument.format(clip=clip) for argument in arguments))
    assert result.exit_code == code, result.output
    assert says in result.stderr
    assert "Traceback" not in result.stderr


def test_a_bad_video_does_not_stop_a_good_one(infer, clip, tmp_path):
    (tmp_path / "bad.mp4").write_bytes(b"not a video")
    result = infer(tmp_path / "bad.mp4", clip, "--format", "json")
    assert result.exit_code == 1
    assert "1 of 2 failed" in result.stderr
    assert clip.with_name("clip.avi.jsonl").exists()


def command(tiny_path, *arguments):
    return [
        *(sys.executable, "-m", "footprints_edge.cli.infer", *map(str, arguments)),
        *("--model", str(tiny_path), "--threads", "1"),
    ]


def test_raw_frames_are_read_from_a_pipe(tiny_path, tmp_path):
    frames = b"".join(shade(index).tobytes() for index in range(7))
    result = subprocess.run(
        command(tiny_path, "-", "--raw", "96x64@10", "-o", tmp_path, "--format", "overlay,json"),
        input=frames + b"cut",
        capture_output=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert b"7 frames" in result.stderr and b"1 broken" in result.stderr
    assert open_video(str(tmp_path / "stdin.overlay.mp4")).total == 7
    assert len((tmp_path / "stdin.jsonl").read_text().splitlines()) == 7


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals for one process")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_finishes_the_video_written_so_far(tiny_path, tmp_path, sent):
    process = subprocess.Popen(
        command(tiny_path, "-", "--raw", "96x64", "-o", tmp_path, "--format", "overlay,json"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    try:
        lines = tmp_path / "stdin.jsonl"
        deadline = time.monotonic() + 60
        while not (lines.exists() and lines.read_text().count("\n") >= 5):
            assert time.monotonic() < deadline
            process.stdin.write(shade(1).tobytes())
            process.stdin.flush()
        os.kill(process.pid, sent)
        process.wait(timeout=30)  # the pipe is still open: nothing but the signal ends it
        errors = process.stderr.read()
    finally:
        process.kill()
        process.stdin.close()
    assert process.returncode == 130
    assert b"Traceback" not in errors
    video = open_video(str(tmp_path / "stdin.overlay.mp4"))
    written = len(lines.read_text().splitlines())
    assert len(indices_of(video)) == written >= 5
    assert not list(tmp_path.glob(".*"))
