"""Small videos whose frames tell their number by their grey level."""

import numpy as np

SIZE = (64, 96)
"""(H, W) of the frames."""


def shade(index):
    """The frame of a number: uint8 (H, W, 3), one grey level."""
    return np.full((*SIZE, 3), 20 + 4 * index, np.uint8)


def index_of(rgb):
    """The number of a decoded frame; rows below `SIZE`, such as a legend, do not count."""
    return round((float(rgb[: SIZE[0]].mean()) - 20) / 4)


def indices_of(video):
    """The numbers of a video's frames, None for broken ones."""
    return [None if frame.rgb is None else index_of(frame.rgb) for frame in video.frames]


def write_video(path, frames=20, fps=10, code="MJPG"):
    """Writes a video of `frames`: a number of shades, or uint8 (N, H, W, 3) in BGR order."""
    import cv2

    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*code), fps, SIZE[::-1])
    for frame in map(shade, range(frames)) if isinstance(frames, int) else frames:
        writer.write(frame)
    writer.release()
    return path
