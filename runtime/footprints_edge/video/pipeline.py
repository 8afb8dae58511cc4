"""A video pipeline: decoding, inference and output run concurrently, in bounded memory."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from queue import Full, Queue
from threading import Event, Semaphore, Thread
from time import perf_counter
from typing import Generic, Literal, Protocol, TypeAlias

from footprints_edge.errors import FootprintsError, VideoError
from footprints_edge.maps.ground_maps import GroundMaps, MapsT
from footprints_edge.video.capture import Video, VideoFrame
from footprints_edge.video.frame_queue import POLL_S, QUEUE_SIZE, FrameQueue

_AHEAD = 2
"""Frames of a file that wait for a thread or for their turn, so that no thread waits for others."""

Ending: TypeAlias = Literal["whole", "interrupted", "failed"]
"""How a video ended: all of it was processed, somebody ended it early, or it failed, which a video
without a usable frame does, too."""


class Sink(Protocol):
    """Receives frames with their predictions, in order."""

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        """Writes one frame."""

    def close(self, ending: Ending) -> None:
        """Finishes the output; called once, even after an error."""


@dataclass
class VideoStats:
    """Counts and timing of a processed video.

    Attributes:
        frames: Number of predicted frames.
        dropped: Number of frames that a live source delivered too fast and that were skipped.
        broken: Number of frames that could not be decoded or predicted.
        reason: Why the first broken frame failed.
        seconds: Elapsed time.
        interrupted: Whether Ctrl-C ended the video.
    """

    frames: int = 0
    dropped: int = 0
    broken: int = 0
    reason: str = ""
    seconds: float = 0.0
    interrupted: bool = False

    @property
    def fps(self) -> float:
        """Frames per second, from the first to the last."""
        return self.frames / self.seconds if self.seconds > 0 else 0.0


def run_pipeline(
    video: Video,
    predict: Callable[[VideoFrame], MapsT],
    sinks: Sequence[Sink],
    progress: Callable[[VideoStats], None] = lambda _: None,
    *,
    at_once: int = 1,
    then: Callable[[MapsT], MapsT] | None = None,
) -> VideoStats:
    """Predicts every frame of a video and passes it to the sinks.

    One thread decodes, `at_once` threads predict, and one feeds the sinks. At most `QUEUE_SIZE`
    frames wait before and after the prediction, and of a file two within it. If a later stage is
    slower, a file waits, while a live source drops its oldest waiting frame. Broken frames are
    counted and skipped. Ctrl-C ends the video early: frames in progress are still written. A sink
    that fails does not stop the others.

    Args:
        video: The video to read; closed at the end.
        predict: Predicts a frame that is not broken; called from `at_once` threads.
        sinks: The outputs; closed at the end, even after an error.
        progress: Callback after every frame.
        at_once: Number of frames to predict in parallel. Two frames on one thread each are faster
            than one after the other on two threads.
        then: Transforms each prediction before the sinks get it; called in this thread, in the
            order of the frames.

    Raises:
        FootprintsError: If the source or a sink fails; the sinks are closed first.
        OSError: Likewise.
    """
    stats = VideoStats()
    start_s = perf_counter()
    decoder = _Decoder(video, stats)
    predictors: _Predictors[MapsT] = _Predictors(
        decoder, predict, at_once, 0 if video.path is None else _AHEAD
    )
    writer = _Writer(sinks)
    item: tuple[VideoFrame, Future[MapsT] | None] | None = None
    finished: VideoFrame | None = None

    def finish(frame: VideoFrame, future: Future[MapsT] | None) -> None:
        nonlocal finished
        try:
            if future is None:
                raise VideoError("cannot be decoded")
            prediction = future.result()
            if then is not None:
                prediction = then(prediction)
        except FootprintsError as error:
            stats.broken += 1
            stats.reason = stats.reason or f"frame {frame.index}: {error}"
            finished = frame
            return
        writer.write(frame, prediction)
        finished = frame
        stats.frames += 1
        stats.seconds = perf_counter() - start_s
        progress(stats)

    for stage in (decoder, predictors, writer):
        stage.start()
    ending: Ending = "failed"
    try:
        while not writer.failed and (item := predictors.next()) is not None:
            finish(*item)
    except KeyboardInterrupt:
        stats.interrupted = True
        predictors.stop()
        if item is not None and item[0] is not finished:  # Ctrl-C came between
            finish(*item)
        while (item := predictors.next()) is not None:
            finish(*item)
        ending = "interrupted"
    else:
        ending = "whole"
    finally:
        predictors.end()
        decoder.end()
        if predictors.error or not stats.frames or (decoder.error and not video.live):
            ending = "failed"
        writer.end(ending)
    stats.seconds = perf_counter() - start_s
    for error in (writer.error, predictors.error, decoder.error):
        if error is not None:
            raise error
    return stats


class _Stage(Thread):
    """A thread at one end of a bounded queue."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.error: Exception | None = None
        self.stopped = Event()

    def run(self) -> None:
        try:
            self.work()
        except Exception as error:  # raised by `run_pipeline`, in the caller's thread
            self.error = error
        finally:
            self.stopped.set()

    def work(self) -> None:
        raise NotImplementedError


class _Decoder(_Stage):
    def __init__(self, video: Video, stats: VideoStats) -> None:
        super().__init__()
        self._video, self._stats = video, stats
        self._queue: FrameQueue[VideoFrame] = FrameQueue(
            live=video.live, on_drop=self._count_dropped
        )

    def work(self) -> None:
        frames = self._video.frames
        try:
            for frame in frames:
                self._queue.put(frame)
                if self._queue.stopped:
                    break
        finally:
            if close := getattr(frames, "close", None):
                close()

    def _count_dropped(self) -> None:
        self._stats.dropped += 1

    def next(self) -> VideoFrame | None:
        """The next frame; None after the last one, or after `stop`."""
        return self._queue.get(self.stopped.is_set)

    def stop(self) -> None:
        self._queue.stop()

    def end(self) -> None:
        self.stop()
        self.join(timeout=10)  # a dead stream may block longer; do not delay the outputs


class _Predictors(_Stage, Generic[MapsT]):
    """Passes each frame to the next free thread; returns the results in order.

    As many as are `ahead` wait for a thread, or are done before the one whose turn it is.
    """

    def __init__(
        self, decoder: _Decoder, predict: Callable[[VideoFrame], MapsT], at_once: int, ahead: int
    ) -> None:
        super().__init__()
        self._decoder, self._predict = decoder, predict
        self._pool = ThreadPoolExecutor(at_once, thread_name_prefix="predict")
        self._free = Semaphore(at_once + ahead)
        self._pending: Queue[tuple[VideoFrame, Future[MapsT] | None] | None] = Queue()
        self._next: tuple[VideoFrame, Future[MapsT] | None] | None = None

    def work(self) -> None:
        try:
            while self._free.acquire() and (frame := self._decoder.next()) is not None:
                broken = frame.rgb is None
                future = None if broken else self._pool.submit(self._predict, frame)
                self._pending.put((frame, future))
        finally:
            self._pending.put(None)

    def next(self) -> tuple[VideoFrame, Future[MapsT] | None] | None:
        """Waits for the prediction of the next frame; None after the last one.

        A frame that could not be decoded has no prediction. A wait that Ctrl-C ends loses none.
        """
        if self._next is None:
            self._next = self._pending.get()
        item, future = self._next, self._next and self._next[1]
        if future is not None:
            wait([future])
        self._next = None
        if item is not None:
            self._free.release()
        return item

    def stop(self) -> None:
        self._decoder.stop()
        self._free.release()

    def end(self) -> None:
        self.stop()
        self.join()
        self._pool.shutdown(cancel_futures=True)


class _Writer(_Stage):
    def __init__(self, sinks: Sequence[Sink]) -> None:
        super().__init__()
        self._open = list(sinks)
        self._ending: Ending = "failed"
        self._queue: Queue[tuple[VideoFrame, GroundMaps] | None] = Queue(QUEUE_SIZE)

    @property
    def failed(self) -> bool:
        """Whether no sink is left."""
        return self.error is not None and not self._open

    def work(self) -> None:
        while not self.failed and (item := self._queue.get()) is not None:
            for sink in list(self._open):
                try:
                    sink.write(*item)
                except Exception as error:  # the other sinks go on
                    self.error = self.error or error
                    self._open.remove(sink)
                    self._close(sink, "failed")
        while self._open:
            self._close(self._open.pop(0), self._ending)

    def _close(self, sink: Sink, ending: Ending) -> None:
        try:
            sink.close(ending)
        except Exception as error:
            self.error = self.error or error

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        self._put((frame, prediction))

    def end(self, ending: Ending) -> None:
        """Waits until everything is written."""
        self._ending = ending
        self._put(None)
        self.join()

    def _put(self, item: tuple[VideoFrame, GroundMaps] | None) -> None:
        while not self.stopped.is_set():
            try:
                self._queue.put(item, timeout=POLL_S)
                return
            except Full:
                pass
