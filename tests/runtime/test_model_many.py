"""A model for many pictures and for videos, in other processes, and as a function."""

import copy
import io
import os
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest
from PIL import Image
from videos import index_of

import footprints_edge as fp


@pytest.fixture
def photos(tmp_path, picture):
    """Twelve pictures, each of its own brightness, whose sixth is damaged."""
    paths = [tmp_path / f"{index:02}.png" for index in range(12)]
    for index, path in enumerate(paths):
        Image.fromarray(picture // (index + 1)).save(path)
    paths[5].write_bytes(b"not a picture")
    return paths


def test_a_model_is_a_function(tiny, picture):
    np.testing.assert_array_equal(tiny(picture).ground, tiny.predict(picture).ground)


@pytest.mark.parametrize("workers", [None, 1, 5])
def test_many_pictures_come_in_order_and_a_bad_one_stops_nothing(tiny, photos, workers):
    results = tiny.predict_many(iter(photos), workers=workers, flatten=False)
    names = []
    while True:
        try:
            names.append(next(results).name)
        except fp.ImageError:
            names.append(None)
        except StopIteration:
            break
    assert names == [path.name if index != 5 else None for index, path in enumerate(photos)]


def test_many_pictures_are_taken_as_they_are_needed(tiny, picture):
    taken = []
    endless = (taken.append(1) or picture for _ in iter(int, 1))
    results = tiny.predict_many(endless, workers=2)
    assert [next(results).map_size for _ in range(3)]
    results.close()
    assert len(taken) < 12


def test_a_pose_that_is_known_holds_for_all(tiny, picture, clip):
    pose = {"camera_height_m": np.float32(1.25), "pitch_deg": 12, "roll_deg": -3}
    (many,) = tiny.predict_many([picture], **pose)
    frame = next(tiny.stream(clip, smooth=True, **pose))
    for plane in (many.ground_plane(), frame.prediction.ground_plane()):
        found = (plane.camera_height_m, plane.pitch_deg, plane.roll_deg)
        assert found == pytest.approx((1.25, 12, -3))


def test_one_picture_is_not_many(tiny, photos):
    pixels = np.zeros((20, 30, 3), np.uint8)
    for one in (str(photos[0]), photos[0], photos[0].read_bytes(), pixels):
        with pytest.raises(TypeError, match="one picture"):
            tiny.predict_many(one)


def test_workers_are_positive(tiny):
    with pytest.raises(ValueError, match="workers"):
        tiny.predict_many([], workers=0)


def test_a_video_is_an_iterator(tiny, clip):
    frames = list(tiny.stream(clip, every=2))
    assert [frame.index for frame in frames] == list(range(0, 20, 2))
    assert [index_of(frame.prediction.rgb) for frame in frames] == list(range(0, 20, 2))
    assert [frame.time_s for frame in frames] == pytest.approx([index / 5 for index in range(10)])


def test_a_pipe_is_an_iterator_and_stays_open(tiny, picture):
    frames = np.stack([picture // (index + 1) for index in range(3)])
    pipe = io.BytesIO(frames.tobytes())
    layout = f"{picture.shape[1]}x{picture.shape[0]}@10"
    found = list(tiny.stream(pipe, raw=layout))
    assert [frame.time_s for frame in found] == [0, 0.1, 0.2]
    for frame, sent in zip(found, frames, strict=True):
        np.testing.assert_array_equal(frame.prediction.ground, tiny(sent).ground)
    assert not pipe.closed


def test_leaving_a_stream_leaves_no_thread(tiny, clip):
    before = threading.active_count()
    for frame in tiny.stream(clip, workers=2, smooth=True):
        if frame.index == 3:
            break
    del frame
    assert threading.active_count() == before


def test_a_video_that_is_not_there_is_said_at_once(tiny):
    with pytest.raises(fp.VideoError, match="no such file"):
        tiny.stream("nowhere.mp4")


def test_a_model_is_pickled_by_its_path(tiny, tiny_path, picture):
    again = pickle.loads(pickle.dumps(tiny))
    assert len(pickle.dumps(tiny)) < 2000
    assert (again.sha256, again.engine.threads) == (tiny.sha256, 1)
    np.testing.assert_array_equal(again(picture).ground, tiny(picture).ground)
    assert str(tiny_path) in repr(copy.copy(tiny))


def test_another_file_is_not_taken_for_the_pickled_one(tmp_path, model_bytes):
    path = tmp_path / "a.onnx"
    path.write_bytes(model_bytes())
    pickled = pickle.dumps(fp.load(path, threads=1))
    path.write_bytes(model_bytes((32, 64)))
    with pytest.raises(fp.ModelError, match="another file"):
        pickle.loads(pickled)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_process_predicts_reloads_and_ends(tiny_path, picture, tmp_path):
    Image.fromarray(picture).save(tmp_path / "a.png")
    code = """
import os, signal, sys
import footprints_edge as fp
model = fp.load(sys.argv[1], threads=2)
expected = model.predict(sys.argv[2]).ground.sum()
child = os.fork()
if child == 0:
    signal.alarm(60)
    assert model.predict(sys.argv[2]).ground.sum() == expected
    assert fp.load(sys.argv[1], threads=2).predict(sys.argv[2]).ground.sum() == expected
    sys.exit(0)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    subprocess.run(
        [sys.executable, "-c", code, tiny_path, tmp_path / "a.png"], check=True, timeout=90
    )


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_a_pool_of_processes_takes_a_model(method, tiny_path, tmp_path, picture):
    Image.fromarray(picture).save(tmp_path / "a.png")
    code = """
import multiprocessing, sys
import footprints_edge as fp
if __name__ == "__main__":
    model = fp.load(sys.argv[2], threads=1)
    with multiprocessing.get_context(sys.argv[1]).Pool(1) as pool:
        (found,) = pool.map(model, [sys.argv[3]])
    assert (found.ground == model(sys.argv[3]).ground).all()
"""
    (tmp_path / "program.py").write_text(code)
    words = [tmp_path / "program.py", method, tiny_path, tmp_path / "a.png"]
    subprocess.run([sys.executable, *words], check=True, timeout=90)


def test_numbers_of_numpy_and_any_path(tiny, picture, tmp_path):
    camera = fp.Intrinsics(*np.float32([80, 80, 50, 30]))
    prediction = tiny.predict(picture, threshold=np.float32(0.5), intrinsics=camera)
    assert prediction.save(tmp_path, ["json"])
    assert [type(prediction.threshold), type(camera.fx)] == [float, float]


@pytest.mark.parametrize(
    "numbers", [(1e300, 400, 0, 0), (1e-300, 400, 1e300, 0), (400, 400, 1e12, 0), ("x", 1, 1, 1)]
)
def test_cameras_that_cannot_be_are_refused(numbers):
    with pytest.raises(fp.IntrinsicsError):
        fp.Intrinsics(*numbers)


@pytest.mark.parametrize("given", [None, (1, 2, 3, 4)])
def test_a_function_that_gives_no_camera_is_named(given, tiny, picture):
    with pytest.raises(fp.IntrinsicsError, match="function for intrinsics"):
        tiny.predict(picture, intrinsics=lambda _: given)


def test_providers_and_session_options_are_passed_through(tiny_path, picture):
    model = fp.load(
        tiny_path,
        threads=1,
        providers=[("CPUExecutionProvider", {"use_arena": "0"})],
        session_options={"session.intra_op.allow_spinning": "0"},
    )
    assert model(picture).map_size
    with pytest.raises(fp.ModelError, match="NoProvider"):
        fp.load(tiny_path, providers=[("NoProvider", {})])
