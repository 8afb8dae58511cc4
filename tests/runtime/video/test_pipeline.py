"""The pipeline of a video: order, concurrency, live sources, failures and interrupts."""

import threading
import time
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from videos import shade

from footprints_edge.errors import ModelError, VideoError
from footprints_edge.video import pipeline
from footprints_edge.video.capture import Video, VideoFrame, open_video
from footprints_edge.video.pipeline import QUEUE_SIZE, run_pipeline

PATIENCE_S = 20
"""Events and barriers fail after this time; a pipeline that works never waits so long."""


class Collector:
    """A sink that keeps its frames; it may be slow, or fail at a frame."""

    def __init__(self, delay_s=0.0, fails_at=None):
        self.got, self.endings, self.delay_s, self.fails_at = [], [], delay_s, fails_at

    def write(self, frame, prediction):
        if len(self.got) == self.fails_at:
            raise OSError("disk full")
        time.sleep(self.delay_s)
        self.got.append((frame.index, prediction))

    def close(self, ending):
        self.endings.append(ending)

    @property
    def closed(self):
        return len(self.endings)

    @property
    def indices(self):
        return [index for index, _ in self.got]


class WaitingSink(Collector):
    """A sink that calls a function with each frame's index before it keeps the frame."""

    def __init__(self, before):
        super().__init__()
        self._before = before

    def write(self, frame, prediction):
        self._before(frame.index)
        super().write(frame, prediction)


def source(frames, live=False, path=None):
    return Video("synthetic", live, 30.0, frames, path=path)


def numbered(index):
    """A frame that carries its number in every pixel."""
    return VideoFrame(index, index / 30, np.full((4, 4, 3), index, np.uint8))


def number_of(frame):
    return int(frame.rgb[0, 0, 0])


def some_frames(number, broken=()):
    for index in range(number):
        yield VideoFrame(index, index / 30, None if index in broken else shade(0))


def test_every_frame_of_a_file_reaches_the_sinks_in_order():
    sink = Collector(delay_s=0.002)
    stats = run_pipeline(source(some_frames(50)), lambda frame: frame.rgb.sum(), [sink])
    assert sink.indices == list(range(50))
    assert (stats.frames, stats.dropped, stats.broken, sink.closed) == (50, 0, 0, 1)


def test_stages_overlap():
    """Decoding frame 2, predicting frame 1 and writing frame 0 each wait for the two others."""
    together = threading.Barrier(3, timeout=PATIENCE_S)

    def decoded():
        yield numbered(0)
        yield numbered(1)
        together.wait()
        yield numbered(2)

    def predict(frame):
        if number_of(frame) == 1:
            together.wait()

    sink = WaitingSink(lambda index: together.wait() if index == 0 else None)
    run_pipeline(source(decoded()), predict, [sink])
    assert sink.indices == [0, 1, 2]


def test_frames_are_predicted_in_parallel_and_come_out_in_order():
    """Three frames at a time wait for each other, and the first of them ends last."""
    together = threading.Barrier(3, timeout=PATIENCE_S)
    ended = [threading.Event() for _ in range(24)]
    followed = []

    def predict(frame):
        index = number_of(frame)
        together.wait()
        if index % 3 == 0:
            assert all(event.wait(PATIENCE_S) for event in ended[index + 1 : index + 3])
        ended[index].set()
        return index

    def then(number):
        followed.append(number)
        return -number

    sink = Collector()
    stats = run_pipeline(source(map(numbered, range(24))), predict, [sink], at_once=3, then=then)
    assert followed == list(range(24))
    assert sink.got == [(i, -i) for i in range(24)]
    assert (stats.frames, stats.broken) == (24, 0)


def test_a_live_source_does_not_hold_back_predicted_frames():
    """The camera sends its second frame only after the first one is written."""
    first_written = threading.Event()
    in_time = []

    def camera():
        yield numbered(0)
        in_time.append(first_written.wait(PATIENCE_S))
        yield numbered(1)

    sink = WaitingSink(lambda _: first_written.set())
    run_pipeline(source(camera(), live=True), number_of, [sink], at_once=2)
    assert in_time == [True]
    assert sink.indices == [0, 1]


def test_a_live_source_keeps_all_predictors_busy():
    """Predictions end only once four of them run; the camera sends a frame as one begins."""
    together = threading.Barrier(4, timeout=PATIENCE_S)
    begun = [threading.Event() for _ in range(8)]

    def camera():
        for index in range(8):
            yield numbered(index)
            assert begun[index].wait(PATIENCE_S)

    def predict(frame):
        begun[number_of(frame)].set()
        together.wait()

    sink = Collector()
    stats = run_pipeline(source(camera(), live=True), predict, [sink], at_once=4)
    assert (stats.frames, stats.dropped) == (8, 0)


def test_begun_frames_are_written_when_the_video_is_interrupted():
    begun = []

    def predict(frame):
        begun.append(number_of(frame))
        time.sleep(0.05)
        return begun[-1]

    def stop(stats):
        if stats.frames == 3:
            raise KeyboardInterrupt

    sink = Collector()
    stats = run_pipeline(source(map(numbered, range(100))), predict, [sink], stop, at_once=4)
    assert stats.interrupted
    assert sink.indices == sorted(begun)
    assert len(begun) < 20


@pytest.mark.parametrize("during", ["wait", "then"])
def test_the_frame_at_which_ctrl_c_comes_is_written(during, monkeypatch):
    calls = []

    def interrupted(value, **_):
        calls.append(value)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return value

    if during == "wait":
        monkeypatch.setattr(pipeline, "wait", interrupted)
    sink = Collector()
    then = interrupted if during == "then" else None
    stats = run_pipeline(source(map(numbered, range(100))), number_of, [sink], then=then)
    assert stats.interrupted
    assert sink.indices == list(range(stats.frames))
    assert stats.frames >= 3


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
        lambda stats: lead.append(len(read) - stats.frames),
    )
    assert max(lead) <= QUEUE_SIZE + 2
    assert len(sink.got) == 30


@pytest.mark.parametrize(("path", "begun"), [(Path("walk.mp4"), 4), (None, 2)])
def test_one_slow_frame_keeps_no_thread_waiting_for_its_turn(path, begun):
    """Two frames of a file go on without it; frames of a pipe are not taken before they are due."""
    started, at_the_end = [], []

    def predict(frame):
        started.append(frame.index)
        if frame.index == 0:
            deadline_s = time.monotonic() + (PATIENCE_S if path else 0.2)
            while len(started) < 4 and time.monotonic() < deadline_s:
                time.sleep(0.002)
            at_the_end.append(len(started))

    run_pipeline(source(some_frames(30), path=path), predict, [Collector()], at_once=2)
    assert at_the_end == [begun]


def test_a_live_source_drops_the_oldest_frames_and_never_waits():
    """The sink writes nothing until the camera has sent all of its frames."""
    sent = threading.Event()

    def camera():
        yield from some_frames(100)
        sent.set()

    def wait_for_camera(_):
        assert sent.wait(PATIENCE_S), "the camera had to wait for the sink"

    sink = WaitingSink(wait_for_camera)
    stats = run_pipeline(source(camera(), live=True), lambda _: None, [sink])
    assert sink.indices == sorted(sink.indices)
    assert sink.indices[-1] == 99
    assert stats.frames <= 3 * (QUEUE_SIZE + 1)  # waiting or under way when the last one came
    assert stats.dropped + stats.frames == 100


def test_broken_frames_are_counted_and_the_others_come_out():
    calls = count()

    def predict(frame):
        if next(calls) == 2:
            raise ModelError("no memory for this one")
        return frame

    sink = Collector()
    stats = run_pipeline(source(some_frames(10, broken={4, 5})), predict, [sink])
    assert sink.indices == [0, 1, 3, 6, 7, 8, 9]
    assert (stats.frames, stats.broken) == (7, 3)
    assert stats.reason == "frame 2: no memory for this one"


def test_a_video_stops_when_no_sink_is_left():
    bad = Collector(fails_at=3)
    endless = (VideoFrame(index, index / 30, shade(0)) for index in count())
    with pytest.raises(OSError, match="disk full"):
        run_pipeline(source(endless), lambda frame: frame, [bad])
    assert bad.endings == ["failed"]


def test_a_failing_sink_does_not_stop_the_others():
    good, bad = Collector(), Collector(fails_at=3)
    with pytest.raises(OSError, match="disk full"):
        run_pipeline(source(some_frames(20)), lambda frame: frame, [bad, good])
    assert (good.indices, good.endings) == (list(range(20)), ["whole"])
    assert bad.endings == ["failed"]


def test_a_video_without_a_usable_frame_failed():
    sink = Collector()
    run_pipeline(source(some_frames(0)), lambda frame: frame, [sink])
    assert sink.endings == ["failed"]


def test_an_error_of_the_source_is_raised_after_its_frames_are_written():
    def failing():
        yield from some_frames(5)
        raise VideoError("the camera is gone")

    sink = Collector()
    with pytest.raises(VideoError, match="the camera is gone"):
        run_pipeline(source(failing()), lambda frame: frame, [sink])
    assert (len(sink.got), sink.endings) == (5, ["failed"])


def test_no_thread_is_left_behind(clip):
    before = threading.active_count()
    run_pipeline(open_video(str(clip)), lambda frame: frame, [Collector()])
    assert threading.active_count() == before
