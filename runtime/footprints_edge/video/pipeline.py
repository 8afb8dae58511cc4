"""Decoding, inference and output of a video at the same time, in bounded memory."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from queue import Empty, Full, Queue
from threading import Event, Semaphore, Thread
from time import perf_counter
from typing import Generic, Protocol

from footprints_edge.errors import FootprintsError, VideoError
from footprints_edge.foundation.types import Rgb
from footprints_edge.maps.ground_maps import GroundMaps, MapsT
from footprints_edge.video.capture import Frame, Video

WAITING = 2
"""Frames that may wait between two stages."""

_LOOK_UP_S = 0.1
"""A stage that waits looks so often whether the others have stopped."""


class Sink(Protocol):
    """Something that takes frames with their predictions, in order."""

    def write(self, frame: Frame, prediction: GroundMaps) -> None:
        """Takes one."""

    def close(self) -> None:
        """Ends it; called once, whatever happened."""


@dataclass
class Tally:
    """What became of a video.

    Attributes:
        frames: How many were predicted.
        dropped: How many of a live source came too fast, and were left out.
        broken: How many could not be decoded or predicted.
        reason: Why the first of these could not.
        seconds: How long it took.
        interrupted: Whether Ctrl-C ended it.
    """

    frames: int = 0
    dropped: int = 0
    broken: int = 0
    reason: str = ""
    seconds: float = 0.0
    interrupted: bool = False

    @property
    def fps(self) -> float:
        """Frames a second, from the first to the last."""
        return self.frames / self.seconds if self.seconds > 0 else 0.0


def run_pipeline(
    video: Video,
    predict: Callable[[Rgb], MapsT],
    sinks: Sequence[Sink],
    progress: Callable[[Tally], None] = lambda _: None,
    *,
    at_once: int = 1,
    then: Callable[[MapsT], MapsT] | None = None,
) -> Tally:
    """Predicts every frame of a video and hands it to the sinks.

    One thread decodes, some predict, another feeds the sinks; at most `WAITING` frames wait before
    and after the prediction. Where the others are slower, a file waits; a live source goes on, and
    the oldest frame that waits makes room. A frame that is broken is counted. Ctrl-C ends the video
    as its end does, with all that was begun.

    Args:
        video: To read; closed at the end.
        predict: Makes the prediction of a frame; called from `at_once` threads.
        sinks: Closed at the end, whatever happens.
        progress: Told after every frame.
        at_once: Frames that are predicted at the same time. Two frames on one thread each take
            less time than one after the other on two.
        then: Takes each prediction in the order of the frames, in this thread, and gives the one
            for the sinks.

    Raises:
        FootprintsError: If the source or a sink fails; the sinks are closed before.
        OSError: Likewise.
    """
    tally = Tally()
    began_s = perf_counter()
    decoder = _Decoder(video, tally)
    predictors: _Predictors[MapsT] = _Predictors(decoder, predict, at_once)
    writer = _Writer(sinks)

    def take(frame: Frame, coming: Future[MapsT] | None) -> None:
        try:
            if coming is None:
                raise VideoError("cannot be decoded")
            prediction = coming.result()
            if then is not None:
                prediction = then(prediction)
        except FootprintsError as error:
            tally.broken += 1
            tally.reason = tally.reason or f"frame {frame.index}: {error}"
            return
        writer.give(frame, prediction)
        tally.frames += 1
        tally.seconds = perf_counter() - began_s
        progress(tally)

    for stage in (decoder, predictors, writer):
        stage.start()
    try:
        while not writer.failed and (item := predictors.next()) is not None:
            take(*item)
    except KeyboardInterrupt:
        tally.interrupted = True
        predictors.stop()
        while (item := predictors.next()) is not None:
            take(*item)
    finally:
        predictors.end()
        decoder.end()
        writer.end()
    tally.seconds = perf_counter() - began_s
    for failed in (writer.error, predictors.error, decoder.error):
        if failed is not None:
            raise failed
    return tally


class _Stage(Thread):
    """A thread at one end of a bounded queue."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.error: Exception | None = None
        self.stopped = Event()

    def run(self) -> None:
        try:
            self.work()
        except Exception as error:  # handed to the caller, in its own thread
            self.error = error
        finally:
            self.stopped.set()

    def work(self) -> None:
        raise NotImplementedError


class _Decoder(_Stage):
    def __init__(self, video: Video, tally: Tally) -> None:
        super().__init__()
        self._video, self._tally = video, tally
        self._queue: Queue[Frame] = Queue(WAITING)
        self._enough = Event()

    def work(self) -> None:
        frames = self._video.frames
        try:
            for frame in frames:
                self._offer(frame)
                if self._enough.is_set():
                    break
        finally:
            if close := getattr(frames, "close", None):
                close()

    def _offer(self, frame: Frame) -> None:
        while not self._enough.is_set():
            try:
                self._queue.put(frame, timeout=0 if self._video.live else _LOOK_UP_S)
                return
            except Full:
                if self._video.live:
                    self._drop_oldest()

    def _drop_oldest(self) -> None:
        try:
            self._queue.get_nowait()
            self._tally.dropped += 1
        except Empty:  # it was just taken
            pass

    def next(self) -> Frame | None:
        """The next frame; None after the last one, and when no more are wanted."""
        while not self._enough.is_set():
            ended = self.stopped.is_set()
            try:
                return self._queue.get(timeout=0 if ended else _LOOK_UP_S)
            except Empty:
                if ended:
                    return None
        return None

    def stop(self) -> None:
        self._enough.set()

    def end(self) -> None:
        self.stop()
        self.join(timeout=10)  # a dead stream may hold it longer: the outputs come first


class _Predictors(_Stage, Generic[MapsT]):
    """Hands each frame to a free thread as soon as there is one; gives the results in order."""

    def __init__(self, decoder: _Decoder, predict: Callable[[Rgb], MapsT], at_once: int) -> None:
        super().__init__()
        self._decoder, self._predict = decoder, predict
        self._pool = ThreadPoolExecutor(at_once, thread_name_prefix="predict")
        self._free = Semaphore(at_once)
        self._underway: Queue[tuple[Frame, Future[MapsT] | None] | None] = Queue()

    def work(self) -> None:
        try:
            while self._free.acquire() and (frame := self._decoder.next()) is not None:
                rgb = frame.rgb
                coming = None if rgb is None else self._pool.submit(self._predict, rgb)
                self._underway.put((frame, coming))
        finally:
            self._underway.put(None)

    def next(self) -> tuple[Frame, Future[MapsT] | None] | None:
        """The next frame, when it is predicted; None after the last one.

        A frame that could not be decoded has no prediction.
        """
        item = self._underway.get()
        if item is not None:
            if item[1] is not None:
                wait([item[1]])
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
        self._sinks = sinks
        self._queue: Queue[tuple[Frame, GroundMaps] | None] = Queue(WAITING)

    @property
    def failed(self) -> bool:
        return self.error is not None

    def work(self) -> None:
        try:
            while (item := self._queue.get()) is not None:
                for sink in self._sinks:
                    sink.write(*item)
        finally:
            for sink in self._sinks:
                sink.close()

    def give(self, frame: Frame, prediction: GroundMaps) -> None:
        self._put((frame, prediction))

    def end(self) -> None:
        """Ends when all that was given is written."""
        self._put(None)
        self.join()

    def _put(self, item: tuple[Frame, GroundMaps] | None) -> None:
        while not self.stopped.is_set():
            try:
                self._queue.put(item, timeout=_LOOK_UP_S)
                return
            except Full:
                pass
