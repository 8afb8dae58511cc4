"""Output files of a video: names, an overlay video, and JSON Lines."""

import json

import numpy as np
import pytest
from predictions import make_prediction
from videos import indices_of

from footprints_edge.errors import OutputError
from footprints_edge.video.capture import VideoFrame, open_video
from footprints_edge.video.file import VideoFile
from footprints_edge.video.overlay import VideoOverlay
from footprints_edge.video.sinks import SUFFIXES, open_sinks, video_paths

pytest.importorskip("cv2")

SIZE = (64, 96)


def prediction_of(index):
    """A frame of one grey level with ground in its lower half, 1 m per frame away."""
    ground = np.repeat(np.arange(64) >= 32, 96).reshape(SIZE)
    picture = np.full((*SIZE, 3), 20 + 4 * index, np.uint8)
    return make_prediction(np.full(SIZE, index + 1.0), ground=ground, picture=picture)


def frame(index):
    return VideoFrame(index, index / 10, prediction_of(index).rgb)


def test_files_are_named_after_the_video(tmp_path):
    paths = video_paths(tmp_path, "a.mp4", ["json", "overlay"])
    assert list(paths.items()) == [
        ("json", tmp_path / "a.mp4.jsonl"),
        ("overlay", tmp_path / "a.mp4.overlay.mp4"),
    ]


@pytest.mark.parametrize("formats", [["npz"], ["overlay", "gif"], []])
def test_other_formats_are_refused_with_those_of_videos(tmp_path, formats):
    with pytest.raises(OutputError, match="choose from overlay, json"):
        video_paths(tmp_path, "a.mp4", formats)


def test_each_line_can_be_read_as_soon_as_its_frame_is_written(tmp_path):
    path = tmp_path / "new" / "a.jsonl"
    (sink,) = open_sinks({"json": path}, 10.0, endless=True)
    for index in range(3):
        sink.write(frame(index), prediction_of(index))
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        assert [line["frame"] for line in lines] == list(range(index + 1))
    sink.close("whole")
    assert [line["time_s"] for line in lines] == [0.0, 0.1, 0.2]
    assert [line["ground_fraction"]["all"] for line in lines] == [0.5] * 3
    assert [line["ground_distance_m"]["nearest"] for line in lines] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("bev", [False, True])
def test_the_overlay_has_a_frame_for_each_prediction(tmp_path, bev):
    path = tmp_path / "a.overlay.mp4"
    (sink,) = open_sinks({"overlay": path}, 10.0, bev=bev)
    for index in range(4):
        sink.write(frame(index), prediction_of(index))
    sink.close("whole")
    video = open_video(str(path))
    assert (video.fps, video.total) == (10, 4)
    assert len(indices_of(video)) == 4
    first = next(open_video(str(path)).frames).rgb
    assert first.shape[0] > SIZE[0]  # the legend
    assert (first.shape[1] > 300) == bev


def without_ground(index):
    """A frame of which the network is not sure that it shows any ground."""
    seen = prediction_of(index)
    return seen.with_maps(ground_probability=0.6 * seen.ground_probability)


def test_each_frame_says_whether_it_shows_ground(tmp_path):
    path = tmp_path / "a.jsonl"
    (sink,) = open_sinks({"json": path}, 10.0)
    for index, prediction in enumerate([prediction_of(0), without_ground(1), prediction_of(2)]):
        sink.write(frame(index), prediction)
    sink.close("whole")
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert [bool(line["notes"]) for line in lines] == [False, True, False]
    assert [line["ground_plane"] is None for line in lines] == [False, True, False]
    assert [line["confidence"]["ground"] > 0.5 for line in lines] == [True, False, True]


def test_frames_without_ground_are_drawn_bare_with_another_legend():
    overlay = VideoOverlay(bev=True)
    seen = overlay.draw(prediction_of(0))
    none = overlay.draw(without_ground(0))
    again = overlay.draw(prediction_of(0))
    assert seen.shape == none.shape == again.shape
    np.testing.assert_array_equal(seen, again)
    left = (300 - SIZE[1]) // 2
    assert (none[: SIZE[0], left : left + SIZE[1]] == 20).all()
    assert not (seen[: SIZE[0], left : left + SIZE[1]] == 20).all()
    assert (none[SIZE[0] :] != seen[SIZE[0] :]).any()  # no ground found


@pytest.mark.parametrize(
    ("ending", "left"),
    [
        ("whole", ["a.mp4.jsonl", "a.mp4.overlay.mp4"]),
        ("interrupted", ["a.mp4.partial.jsonl", "a.mp4.partial.overlay.mp4"]),
        ("failed", []),
    ],
)
def test_only_what_is_whole_has_the_name(ending, left, tmp_path):
    sinks = open_sinks(video_paths(tmp_path, "a.mp4", ["overlay", "json"]), 10.0)
    for sink in sinks:
        sink.write(frame(0), prediction_of(0))
    assert not (tmp_path / "a.mp4.jsonl").exists()
    for sink in sinks:
        sink.close(ending)
    assert sorted(path.name for path in tmp_path.iterdir()) == left
    assert sorted(sink.written.name for sink in sinks if sink.written) == left


def test_what_somebody_ends_is_whole(tmp_path):
    sinks = open_sinks(video_paths(tmp_path, "cam", ["overlay", "json"]), 10.0, endless=True)
    for sink in sinks:
        sink.write(frame(0), prediction_of(0))
        sink.close("interrupted")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cam.jsonl", "cam.overlay.mp4"]


def test_without_a_frame_there_is_no_file(tmp_path):
    for sink in open_sinks(video_paths(tmp_path, "cam", ["overlay", "json"]), 10.0, endless=True):
        sink.close("failed")
    assert list(tmp_path.iterdir()) == []


def test_frames_that_are_missing_do_not_make_the_overlay_faster(tmp_path, monkeypatch):
    written = []
    write = VideoFile.write

    def kept(file, bgr):
        written.append((int(bgr[4, bgr.shape[1] // 2, 0]) - 20) // 4)
        write(file, bgr)

    monkeypatch.setattr(VideoFile, "write", kept)
    (sink,) = open_sinks({"overlay": tmp_path / "a.overlay.mp4"}, 10.0)
    for index in (0, 1, 4, 9):
        sink.write(frame(index), prediction_of(index))
    sink.close("whole")
    assert written == [0, 1, 1, 1, 4, 4, 4, 4, 4, 9]
    assert open_video(str(tmp_path / "a.overlay.mp4")).total == 10


def test_a_file_in_place_of_the_folder_is_explained(tmp_path):
    (tmp_path / "file").write_text("")
    for name in SUFFIXES:
        with pytest.raises(OutputError, match="cannot write"):
            open_sinks({name: tmp_path / "file" / "a"}, 10.0)
