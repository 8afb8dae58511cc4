"""Scenes on Ray: those of a single process, to the byte."""

import pytest
from ray_cluster import two_workers
from typer.testing import CliRunner

from footprints_edge_models.cli import app

pytest.importorskip("ray", reason="Ray is an extra: pip install 'footprints-edge[ray]'")


def test_ray_s_workers_write_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the workers' own folder is another
    command = ["--count", "3", "--seed", "3", "--size", "64x96"]
    alone = CliRunner().invoke(app, ["scenes", "alone", *command, "--jobs", "1"])
    assert alone.exit_code == 0, alone.output
    with two_workers():
        on_ray = CliRunner().invoke(app, ["scenes", "ray", *command, "--engine", "ray"])
    assert on_ray.exit_code == 0, on_ray.output
    made = [path for path in (tmp_path / "alone").rglob("*") if path.is_file()]
    assert len(made) >= 6
    for path in made:
        again = tmp_path / "ray" / path.relative_to(tmp_path / "alone")
        assert again.read_bytes() == path.read_bytes(), path
