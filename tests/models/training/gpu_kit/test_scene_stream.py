"""Scenes from other processes."""

import time

import pytest

from footprints_edge_models.training.gpu_kit import scene_stream
from footprints_edge_models.training.gpu_kit.scene_stream import SceneStream, SceneViews

pytest.importorskip("embreex", reason="scenes are traced by embree")


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    assert condition()


def test_views_come_until_the_stream_is_closed():
    stream = SceneStream(SceneViews.of(None, 3, (64, 96), 8192), processes=1)
    views = []
    try:
        wait_for(lambda: views.extend(stream.ready(10)) or len(views) >= 2)
    finally:
        stream.close()
    assert not stream.alive
    assert stream.scenes >= 2
    assert all(view.size[0] * view.size[1] <= 8192 for view in views)
    assert all((view.depths_m > 0).any() for view in views)


def test_a_stream_that_can_make_nothing_gives_up(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(scene_stream, "_HOPELESS", 3)
    stream = SceneStream(SceneViews.of(tmp_path / "absent.zip", 3, (64, 96), 8192), processes=1)
    try:
        wait_for(lambda: not stream.alive)
    finally:
        stream.close()
    assert stream.failed == 3
    assert list(stream.ready(10)) == []
    assert "absent.zip" in caplog.text
