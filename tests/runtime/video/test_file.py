"""Video files that are written."""

import os

import numpy as np
import pytest
from videos import indices_of, shade

from footprints_edge.errors import VideoError
from footprints_edge.video import file as file_module
from footprints_edge.video.capture import open_video
from footprints_edge.video.file import VideoFile

pytest.importorskip("cv2")


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
    assert np.diff(indices_of(again)[:5]).tolist() == [1, 1, 1, 1]


@pytest.fixture(params=["with PyAV", "without"])
def encoder(request, monkeypatch):
    """Both encoders."""
    if request.param == "with PyAV":
        return pytest.importorskip("av")
    monkeypatch.setattr("footprints_edge.video.encoders.find_spec", lambda _: None)
    return None


def codec(path):
    import cv2

    code = int(cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FOURCC))
    return code.to_bytes(4, "little").decode().lower()


def test_it_is_a_video_that_browsers_play_if_pyav_is_there(encoder, tmp_path):
    file = VideoFile(tmp_path / "out.mp4", 10.0)
    for index in range(3):
        file.write(shade(index))
    file.close()
    assert codec(tmp_path / "out.mp4") in (
        {"fmp4", "mp4v"} if encoder is None else {"h264", "avc1"}
    )
    found = indices_of(open_video(str(tmp_path / "out.mp4")))
    assert np.diff(found).tolist() == [1, 1]
    if encoder is not None:  # OpenCV's MPEG-4 makes grey a little darker, and reddish
        assert found == [0, 1, 2]


@pytest.mark.usefixtures("encoder")
def test_a_folder_that_cannot_be_written_to_is_explained(tmp_path):
    (tmp_path / "out.mp4").mkdir()
    with pytest.raises(VideoError, match="cannot be written"):
        VideoFile(tmp_path / "out.mp4", 10.0).write(shade(0))


@pytest.mark.usefixtures("encoder")
@pytest.mark.parametrize("fps", [119.997, 211.222, 66.667, 29.97, 480.0, 7.5])
def test_any_rate_can_be_written(fps, tmp_path):
    file = VideoFile(tmp_path / "out.mp4", fps)
    for index in range(3):
        file.write(shade(index))
    file.close()
    assert open_video(str(tmp_path / "out.mp4")).fps == pytest.approx(fps, rel=0.005)


def test_a_name_that_is_not_utf8_can_be_written(tmp_path):
    path = tmp_path / os.fsdecode(b"gr\xfcn") / "out.mp4"
    file = VideoFile(path, 10.0)
    file.write(shade(0))
    file.close()
    assert path.stat().st_size > 0


@pytest.mark.usefixtures("encoder")
@pytest.mark.parametrize("share", [0.0, 0.5, 0.95])
def test_a_file_that_is_cut_is_seen(share, tmp_path, monkeypatch):
    path = tmp_path / "out.mp4"
    file = VideoFile(path, 10.0)
    noise = np.random.default_rng(0)
    for _ in range(20):
        file.write(noise.integers(0, 256, (64, 96, 3), np.uint8))
    looked = file_module.VideoFile._last_frame_is_there

    def cut_first(self):
        os.truncate(path, round(share * path.stat().st_size))
        return looked(self)

    monkeypatch.setattr(file_module.VideoFile, "_last_frame_is_there", cut_first)
    with pytest.raises(VideoError, match="disk full"):
        file.close()
