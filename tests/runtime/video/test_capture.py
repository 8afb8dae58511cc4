"""Videos, cameras and pipes: what comes in, what goes out, and what goes wrong on the way."""

import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from itertools import count

import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge.cli.infer import app
from footprints_edge.errors import ModelError, VideoError
from footprints_edge.foundation import opencv as opencv_module
from footprints_edge.video.capture import (
    Frame,
    Pace,
    RawFormat,
    Video,
    VideoFile,
    open_raw,
    open_video,
)
from footprints_edge.video.pipeline import WAITING, run_pipeline
from footprints_edge.video.sources import is_video

cv2 = pytest.importorskip("cv2")

SIZE = (64, 96)


def shade(index):
    """A frame that is told from the others by its grey level."""
    return np.full((*SIZE, 3), 20 + 4 * index, np.uint8)


def index_of(rgb):
    """The number of the `shade` that a frame, decoded again, was."""
    return round((float(rgb[: SIZE[0]].mean()) - 20) / 4)


def write_video(path, frames=20, fps=10, code="MJPG"):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), fps, SIZE[::-1])
    for index in range(frames):
        writer.write(shade(index))
    writer.release()
    return path


@pytest.fixture
def clip(tmp_path):
    return write_video(tmp_path / "clip.avi")


def numbers(video):
    return [None if frame.rgb is None else index_of(frame.rgb) for frame in video.frames]


def infer(tiny_path, *arguments):
    return CliRunner().invoke(
        app, [*map(str, arguments), "--model", str(tiny_path), "--threads", "1"]
    )


def test_the_frames_of_a_file_come_in_order_with_their_times(clip):
    video = open_video(str(clip))
    assert (video.name, video.live, video.fps, video.total) == ("clip.avi", False, 10, 20)
    frames = list(video.frames)
    assert [index_of(frame.rgb) for frame in frames] == list(range(20))
    np.testing.assert_allclose([frame.time_s for frame in frames], np.arange(20) / 10, atol=1e-3)


def test_every_and_max_fps_choose_frames_and_keep_the_speed(clip):
    every = open_video(str(clip), Pace(every=3))
    assert numbers(every) == list(range(0, 20, 3))
    assert every.fps == pytest.approx(10 / 3)
    slow = open_video(str(clip), Pace(max_fps=5))
    assert numbers(slow) == list(range(0, 20, 2))
    assert slow.fps == 5
    assert numbers(open_video(str(clip), Pace(max_fps=50))) == list(range(20))


def test_colours_are_red_green_blue(tmp_path):
    writer = cv2.VideoWriter(
        str(tmp_path / "red.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10, SIZE[::-1]
    )
    writer.write(np.full((*SIZE, 3), (10, 20, 230), np.uint8))  # blue, green, red
    writer.release()
    (frame,) = open_video(str(tmp_path / "red.avi")).frames
    np.testing.assert_allclose(frame.rgb.mean(axis=(0, 1)), [230, 20, 10], atol=6)


def test_damage_is_a_broken_frame_and_what_comes_after_it_is_read(tmp_path):
    whole = write_video(tmp_path / "whole.mp4", 50, 30, "mp4v").read_bytes()
    data = bytearray(whole)
    third = len(data) // 3
    data[third : third + 40] = bytes(40)
    (tmp_path / "damaged.mp4").write_bytes(data)
    found = [frame.rgb is not None for frame in open_video(str(tmp_path / "damaged.mp4")).frames]
    assert len(found) == 50
    assert found[-1]


def test_a_file_that_ends_early_has_broken_frames_at_its_end(tmp_path):
    whole = write_video(tmp_path / "whole.avi", 40).read_bytes()
    (tmp_path / "half.avi").write_bytes(whole[: len(whole) // 2])
    found = numbers(open_video(str(tmp_path / "half.avi")))
    good = [index for index in found if index is not None]
    assert good[:-1] == list(range(len(good) - 1))  # the last one is cut
    assert 5 < len(good) < 35
    assert found[len(good) :] == [None] * (len(found) - len(good))
    assert len(found) > len(good)


@pytest.mark.parametrize(
    ("named", "says"),
    [
        ("nowhere.mp4", "no such file"),
        ("camera:x", "camera's number"),
        ("camera:77", "nothing answers"),
    ],
)
def test_what_cannot_be_opened_says_why(named, says):
    with pytest.raises(VideoError, match=says):
        open_video(named)


def test_a_file_that_is_no_video_says_so(tmp_path):
    (tmp_path / "text.mp4").write_text("no video")
    with pytest.raises(VideoError, match="no video that OpenCV can read"):
        open_video(str(tmp_path / "text.mp4"))


def test_a_missing_opencv_names_the_extra(monkeypatch, clip):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(VideoError, match=r"footprints-edge\[video\]"):
        opencv_module.opencv()
    with pytest.raises(VideoError, match="cv2"):
        open_video(str(clip))


def test_what_is_a_video_is_told_by_its_name():
    assert all(map(is_video, ["a.MP4", "rtsp://host/1", "camera:0", "b/c.webm"]))
    assert not any(map(is_video, ["a.jpg", "-", "folder", "camera.png"]))


def test_raw_frames_come_as_they_are_and_a_short_one_is_broken():
    rng = np.random.default_rng(0)
    sent = rng.integers(0, 256, (3, 4, 6, 3), dtype=np.uint8)
    layout = RawFormat.parse("6x4@25")
    assert layout == RawFormat((4, 6), 25.0)
    video = open_raw(layout, pipe=io.BytesIO(sent.tobytes() + b"half a frame"))
    frames = list(video.frames)
    np.testing.assert_array_equal([frame.rgb for frame in frames[:3]], sent)
    assert frames[3].rgb is None
    assert [frame.time_s for frame in frames] == [0, 0.04, 0.08, 0.12]


@pytest.mark.parametrize("text", ["640", "640x", "axb", "0x4", "6x4@0", "6x4@fast", "6x4x3"])
def test_raw_formats_that_are_none_are_refused(text):
    with pytest.raises(VideoError, match="640x360"):
        RawFormat.parse(text)


class Collector:
    """A sink that keeps what it gets, as slow as it is told to be."""

    def __init__(self, delay_s=0.0, fails_at=None):
        self.got, self.closed, self.delay_s, self.fails_at = [], 0, delay_s, fails_at

    def write(self, frame, prediction):
        if len(self.got) == self.fails_at:
            raise OSError("disk full")
        time.sleep(self.delay_s)
        self.got.append((frame.index, prediction))

    def close(self):
        self.closed += 1


def source(frames, live=False):
    return Video("made", live, 30.0, frames)


def some_frames(number, broken=()):
    for index in range(number):
        yield Frame(index, index / 30, None if index in broken else shade(0))


def test_every_frame_of_a_file_reaches_the_sinks_in_order():
    sink = Collector(delay_s=0.002)
    tally = run_pipeline(source(some_frames(50)), lambda rgb: rgb.sum(), [sink])
    assert [index for index, _ in sink.got] == list(range(50))
    assert (tally.frames, tally.dropped, tally.broken, sink.closed) == (50, 0, 0, 1)


def test_stages_overlap():
    """Three stages of 10 ms each: one after the other they would take 30 ms a frame."""

    def slow():
        for frame in some_frames(30):
            time.sleep(0.01)
            yield frame

    began_s = time.perf_counter()
    run_pipeline(source(slow()), lambda _: time.sleep(0.01), [Collector(0.01)])
    assert time.perf_counter() - began_s < 30 * 0.025


def test_frames_are_predicted_at_once_and_come_out_in_order():
    """Every third frame takes longer than two of the others."""
    lengths_s = [0.03, 0.01, 0.01] * 8
    followed = []

    def predict(rgb):
        time.sleep(lengths_s[int(rgb[0, 0, 0])])
        return int(rgb[0, 0, 0])

    def then(number):
        followed.append(number)
        return -number

    frames = (Frame(i, i / 30, np.full((4, 4, 3), i, np.uint8)) for i in range(24))
    sink = Collector()
    began_s = time.perf_counter()
    tally = run_pipeline(source(frames), predict, [sink], at_once=3, then=then)
    assert time.perf_counter() - began_s < 0.75 * sum(lengths_s)
    assert followed == list(range(24))
    assert sink.got == [(i, -i) for i in range(24)]
    assert (tally.frames, tally.broken) == (24, 0)


def test_a_live_source_does_not_hold_back_what_is_predicted():
    """The next frame comes long after: the first is written before, not when that is there."""
    written = []

    def camera():
        yield from some_frames(1)
        time.sleep(0.5)
        written.append(len(sink.got))
        yield from some_frames(1)

    sink = Collector()
    run_pipeline(source(camera(), live=True), lambda rgb: rgb.sum(), [sink], at_once=2)
    assert written == [1]
    assert len(sink.got) == 2


def test_a_fast_camera_keeps_all_predictors_busy():
    """30 frames a second, 0.1 s each, four at once: hardly one has to go."""

    def camera():
        for frame in some_frames(30):
            time.sleep(1 / 30)
            yield frame

    sink = Collector()
    tally = run_pipeline(source(camera(), live=True), lambda _: time.sleep(0.1), [sink], at_once=4)
    assert tally.dropped <= 5
    assert tally.frames + tally.dropped == 30


def test_what_was_begun_is_written_when_the_video_is_interrupted():
    begun = []

    def predict(rgb):
        begun.append(int(rgb[0, 0, 0]))
        time.sleep(0.05)
        return begun[-1]

    def stop(tally):
        if tally.frames == 3:
            raise KeyboardInterrupt

    frames = (Frame(i, i / 30, np.full((4, 4, 3), i, np.uint8)) for i in range(100))
    sink = Collector()
    tally = run_pipeline(source(frames), predict, [sink], stop, at_once=4)
    assert tally.interrupted
    assert [index for index, _ in sink.got] == sorted(begun)
    assert len(begun) < 20


def test_a_file_waits_for_a_slow_consumer():
    read = []

    def watched():
        for frame in some_frames(30):
            read.append(frame.index)
            yield frame

    sink = Collector(delay_s=0.01)
    lead = []
    run_pipeline(
        source(watched()),
        lambda _: None,
        [sink],
        lambda tally: lead.append(len(read) - tally.frames),
    )
    assert max(lead) <= WAITING + 2
    assert len(sink.got) == 30


def test_a_live_source_drops_the_oldest_frame_and_never_waits():
    def camera():
        for frame in some_frames(100):
            time.sleep(0.002)
            yield frame

    sink = Collector(delay_s=0.02)
    began_s = time.perf_counter()
    tally = run_pipeline(source(camera(), live=True), lambda _: None, [sink])
    assert time.perf_counter() - began_s < 1.0  # 100 frames at the sink's pace: 2 s
    indices = [index for index, _ in sink.got]
    assert indices == sorted(indices)
    assert indices[-1] == 99
    assert tally.dropped > 20
    assert tally.dropped + tally.frames == 100


def test_broken_frames_are_counted_and_the_others_come_out():
    calls = count()

    def predict(rgb):
        if next(calls) == 2:
            raise ModelError("no memory for this one")
        return rgb

    sink = Collector()
    tally = run_pipeline(source(some_frames(10, broken={4, 5})), predict, [sink])
    assert [index for index, _ in sink.got] == [0, 1, 3, 6, 7, 8, 9]
    assert (tally.frames, tally.broken) == (7, 3)
    assert tally.reason == "frame 2: no memory for this one"


def test_a_sink_that_fails_stops_the_video_and_all_sinks_are_closed():
    good, bad = Collector(), Collector(fails_at=3)
    endless = (Frame(index, index / 30, shade(0)) for index in count())
    with pytest.raises(OSError, match="disk full"):
        run_pipeline(source(endless), lambda rgb: rgb, [good, bad])
    assert (good.closed, bad.closed) == (1, 1)


def test_a_source_that_fails_is_told_after_its_frames_are_written():
    def failing():
        yield from some_frames(5)
        raise VideoError("the camera is gone")

    sink = Collector()
    with pytest.raises(VideoError, match="the camera is gone"):
        run_pipeline(source(failing()), lambda rgb: rgb, [sink])
    assert (len(sink.got), sink.closed) == (5, 1)


def test_no_thread_is_left_behind(clip):
    before = threading.active_count()
    run_pipeline(open_video(str(clip)), lambda rgb: rgb, [Collector()])
    assert threading.active_count() == before


def test_a_written_video_is_whole_and_nothing_else_is_left(tmp_path):
    file = VideoFile(tmp_path / "sub" / "out.mp4", 12.0)
    assert list(tmp_path.iterdir()) == []
    for index in range(5):
        file.write(shade(index))
    file.write(np.zeros((32, 48, 3), np.uint8))  # a stream that changed its size
    file.close()
    assert [path.name for path in (tmp_path / "sub").iterdir()] == ["out.mp4"]
    again = open_video(str(tmp_path / "sub" / "out.mp4"))
    assert again.fps == 12
    assert np.diff(numbers(again)[:5]).tolist() == [1, 1, 1, 1]


def test_the_command_makes_an_overlay_video_and_a_line_a_frame(tiny_path, clip):
    result = infer(tiny_path, clip, "--format", "overlay,json", "--every", "2")
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


def test_the_command_keeps_results_and_replaces_them_when_asked(tiny_path, clip):
    assert infer(tiny_path, clip, "--format", "json").exit_code == 0
    lines = clip.with_name("clip.avi.jsonl")
    lines.write_text("mine")
    kept = infer(tiny_path, clip, "--format", "json")
    assert kept.exit_code == 0 and "--overwrite" in kept.stderr
    assert lines.read_text() == "mine"
    assert infer(tiny_path, clip, "--format", "json", "--overwrite").exit_code == 0
    assert len(lines.read_text().splitlines()) == 20


@pytest.mark.parametrize("options", [["--smooth"], ["--bev"], ["--smooth", "--bev"]])
def test_the_command_smooths_and_shows_the_ground_from_above(tiny_path, clip, options):
    assert infer(tiny_path, clip).exit_code == 0
    plain = next(open_video(f"{clip}.overlay.mp4").frames).rgb
    result = infer(tiny_path, clip, "--overwrite", *options)
    assert result.exit_code == 0, result.output
    wide = next(open_video(f"{clip}.overlay.mp4").frames).rgb
    assert (wide.shape[1] > plain.shape[1]) == ("--bev" in options)


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["{clip}", "--format", "npz"], 1, "a video has no format npz"),
        (["{clip}", "--path", "1,1", "2,2"], 2, "--path is for pictures"),
        (["{clip}", "--raw", "64x48"], 2, "give - and nothing else"),
        (["-", "--raw", "64"], 2, "640x360"),
        (["picture.png", "--smooth"], 2, "for videos"),
        (["nowhere.mp4"], 1, "nowhere.mp4: no such file"),
        (["{clip}", "--max-fps", "0"], 2, "positive"),
    ],
)
def test_the_command_says_what_is_wrong(tiny_path, clip, arguments, code, says):
    result = infer(tiny_path, *(argument.format(clip=clip) for argument in arguments))
    assert result.exit_code == code, result.output
    assert says in result.stderr
    assert "Traceback" not in result.stderr


def test_a_good_video_comes_out_beside_a_bad_one(tiny_path, clip, tmp_path):
    (tmp_path / "bad.mp4").write_bytes(b"no video at all")
    result = infer(tiny_path, tmp_path / "bad.mp4", clip, "--format", "json")
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
def test_ctrl_c_closes_the_video_that_was_made_so_far(tiny_path, tmp_path, sent):
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
    assert len(numbers(video)) == written >= 5
    assert not list(tmp_path.glob(".*"))
