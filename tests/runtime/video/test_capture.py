"""Frames of files, cameras and pipes, broken ones included."""

import io
import os
import shutil
import sys
from itertools import chain, repeat
from threading import Timer
from types import SimpleNamespace

import numpy as np
import pytest
from videos import SIZE, index_of, indices_of, write_video

from footprints_edge.errors import VideoError
from footprints_edge.foundation import opencv as opencv_module
from footprints_edge.video import capture
from footprints_edge.video.capture import Pace, RawFormat, open_raw, open_source, open_video
from footprints_edge.video.sources import is_video

cv2 = pytest.importorskip("cv2")


def test_the_frames_of_a_file_come_in_order_with_their_times(clip):
    video = open_video(str(clip))
    assert (video.name, video.live, video.fps, video.total) == ("clip.avi", False, 10, 20)
    frames = list(video.frames)
    assert [index_of(frame.rgb) for frame in frames] == list(range(20))
    np.testing.assert_allclose([frame.time_s for frame in frames], np.arange(20) / 10, atol=1e-3)


def test_every_and_max_fps_choose_frames_and_keep_the_speed(clip):
    every = open_video(str(clip), Pace(every=3))
    assert indices_of(every) == list(range(0, 20, 3))
    assert every.fps == pytest.approx(10 / 3)
    slow = open_video(str(clip), Pace(max_fps=5))
    assert indices_of(slow) == list(range(0, 20, 2))
    assert slow.fps == 5
    assert indices_of(open_video(str(clip), Pace(max_fps=50))) == list(range(20))


def test_colours_are_red_green_blue(tmp_path):
    red = np.full((1, *SIZE, 3), (10, 20, 230), np.uint8)  # blue, green, red
    (frame,) = open_video(str(write_video(tmp_path / "red.avi", red))).frames
    np.testing.assert_allclose(frame.rgb.mean(axis=(0, 1)), [230, 20, 10], atol=6)


def test_frames_after_a_damaged_one_are_read(tmp_path):
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
    found = indices_of(open_video(str(tmp_path / "half.avi")))
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
        ("camera:77", "no answer"),
        (".", "a folder"),
        (os.devnull, "not a file"),
        ("http://me:hunter22@10.0.0.7/a.mjpg", r"http://\*\*\*@10.0.0.7/a.mjpg: addresses of"),
    ],
)
def test_an_input_that_cannot_be_opened_is_explained(named, says):
    with pytest.raises(VideoError, match=says):
        open_video(named)


def test_a_file_that_is_not_a_video_is_explained(tmp_path):
    (tmp_path / "text.mp4").write_text("no video")
    with pytest.raises(VideoError, match="not a video that OpenCV can read"):
        open_video(str(tmp_path / "text.mp4"))


def test_a_missing_opencv_names_the_extra(monkeypatch, clip):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(VideoError, match=r"footprints-edge\[video\]"):
        opencv_module.opencv()
    with pytest.raises(VideoError, match="cv2"):
        open_video(str(clip))


def test_videos_are_recognised_by_name():
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
def test_invalid_raw_formats_are_refused(text):
    with pytest.raises(VideoError, match="640x360"):
        RawFormat.parse(text)


@pytest.mark.parametrize(("fps", "most"), [(30, 20), (30, 29), (29.97, 25), (15, 20), (60, 7)])
def test_max_fps_keeps_that_many_frames_whatever_the_rate(fps, most):
    clock = Pace(max_fps=most).clock()
    taken = sum(clock.takes(index, index / fps) for index in range(round(10 * fps)))
    assert taken == pytest.approx(10 * min(fps, most), abs=1)


def test_after_a_gap_the_pace_goes_on():
    clock = Pace(max_fps=10).clock()
    taken = [time_s for time_s in [0, 0.05, 0.1, 5.0, 5.05, 5.1] if clock.takes(0, time_s)]
    assert taken == [0, 0.1, 5.0, 5.1]


def test_names_that_opencv_cannot_take_are_opened(tmp_path, monkeypatch, clip):
    monkeypatch.chdir(tmp_path)
    for name in ("12:30:05.avi", os.fsdecode(b"gr\xfcn.avi")):
        shutil.copy(clip, name)
        assert len(indices_of(open_video(name))) == 20


class FakeCamera:
    """A camera that gives its frames, with failures to grab between them."""

    def __init__(self, grabs):
        self._grabs = iter(grabs)

    def grab(self):
        return next(self._grabs)

    def retrieve(self):
        return True, np.zeros((4, 4, 3), np.uint8)

    def get(self, _):
        return 0.0

    def release(self):
        pass


def test_a_gap_of_a_camera_is_one_broken_frame(monkeypatch):
    monkeypatch.setattr(capture, "_POLL_S", 0.0)
    grabs = [False] * 5 + [True] * 3 + [False] * 10 + [True] * 2
    camera = FakeCamera(chain(grabs, repeat(False)))
    monkeypatch.setattr(capture, "_TIMEOUT_S", 0.05)
    frames = capture._captured(pytest.importorskip("cv2"), camera, Pace(), 30.0, "camera:0")
    seen = []
    with pytest.raises(VideoError, match="camera:0 has sent nothing"):
        for frame in frames:
            seen.append((frame.index, frame.rgb is not None))
            if len(seen) == 1:
                assert frame.time_s == 0
    assert seen == [(0, True), (1, True), (2, True), (3, False), (4, True), (5, True)]


@pytest.mark.parametrize("given", ["text", None])
def test_a_pipe_that_gives_no_bytes_is_a_video_error(given):
    pipe = SimpleNamespace(read=lambda _: given)
    frames = open_source(pipe, raw="6x4").frames
    with pytest.raises(VideoError, match="binary mode, and blocking"):
        next(frames)


def test_an_unbuffered_pipe_gives_whole_frames():
    sent = np.random.default_rng(0).integers(0, 256, (3, 4, 6, 3), dtype=np.uint8)
    receiving, sending = os.pipe()
    with os.fdopen(receiving, "rb", buffering=0) as pipe:
        frames = open_source(pipe, raw="6x4@25").frames
        for frame in sent:
            os.write(sending, frame.tobytes()[:30])
            later = Timer(0.1, os.write, (sending, frame.tobytes()[30:]))
            later.start()
            np.testing.assert_array_equal(next(frames).rgb, frame)
            later.join()
        os.close(sending)
        assert list(frames) == []


@pytest.mark.parametrize(("source", "raw"), [(io.BytesIO(), None), ("a.mp4", "6x4"), ("-", None)])
def test_a_pipe_and_nothing_else_has_a_layout(source, raw):
    with pytest.raises(VideoError, match="needs the layout of its frames"):
        open_source(source, raw=raw)


def test_raw_frames_need_a_standard_input(monkeypatch):
    monkeypatch.setattr("sys.stdin", None)
    with pytest.raises(VideoError, match="no standard input"):
        open_raw(RawFormat((4, 4)))


def test_a_raw_frame_has_a_limit():
    with pytest.raises(VideoError, match="more than"):
        RawFormat.parse("200000x200000")
