"""A video as an iterator over its predictions, on the pipeline that the command uses."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Thread
from typing import Generic, cast

from footprints_edge.errors import VideoError
from footprints_edge.maps.ground_maps import MapsT
from footprints_edge.video.capture import Video, VideoFrame
from footprints_edge.video.frame_queue import FrameQueue
from footprints_edge.video.pipeline import Ending, Sink, run_pipeline


@dataclass(frozen=True, eq=False)
class StreamedFrame(Generic[MapsT]):
    """One frame of a video.

    Attributes:
        index: Position in the video, from 0; skipped frames count.
        time_s: Seconds since the first frame, by the video's clock, or by ours for live sources.
        prediction: The maps.
    """

    index: int
    time_s: float
    prediction: MapsT


def stream_video(
    video: Video,
    predict: Callable[[VideoFrame], MapsT],
    *,
    then: Callable[[MapsT], MapsT] | None = None,
    at_once: int = 1,
) -> Iterator[StreamedFrame[MapsT]]:
    """Yields the frames of a video; the arguments are those of `run_pipeline`.

    Raises:
        FootprintsError: If the source fails.
    """
    if at_once < 1:
        raise ValueError(f"workers is {at_once}; give a positive number")
    return _frames(video, predict, then, at_once)


def _frames(
    video: Video,
    predict: Callable[[VideoFrame], MapsT],
    then: Callable[[MapsT], MapsT] | None,
    at_once: int,
) -> Iterator[StreamedFrame[MapsT]]:
    sink: _Handover[MapsT] = _Handover()
    failed: list[Exception] = []

    def work() -> None:
        try:
            # the frames that come out are of the kind that `predict` makes
            run_pipeline(video, predict, [cast(Sink, sink)], at_once=at_once, then=then)
        except Exception as error:  # raised below, in the caller's thread
            failed.append(error)

    thread = Thread(target=work, name="stream", daemon=True)
    thread.start()
    try:
        while (frame := sink.frames.get(lambda: not thread.is_alive())) is not None:
            yield frame
    finally:
        sink.frames.stop()
        thread.join(timeout=10)
    if failed:
        raise failed[0]


class _LeftError(VideoError):
    """Nobody takes the frames any more."""


class _Handover(Generic[MapsT]):
    """A sink whose frames another thread takes."""

    def __init__(self) -> None:
        self.frames: FrameQueue[StreamedFrame[MapsT]] = FrameQueue(live=False, size=1)

    def write(self, frame: VideoFrame, prediction: MapsT) -> None:
        self.frames.put(StreamedFrame(frame.index, frame.time_s, prediction))
        if self.frames.stopped:
            raise _LeftError("the iterator was closed")

    def close(self, ending: Ending) -> None:
        """Nothing to finish."""
