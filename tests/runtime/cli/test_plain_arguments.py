"""The usual command lines mean what typer takes them for."""

import subprocess
import sys
from inspect import signature

import pytest
from typer.testing import CliRunner

from footprints_edge.cli import infer as module
from footprints_edge.cli.plain_arguments import read_plain


@pytest.fixture
def by_typer():
    """Function: what typer passes for a command line."""

    app = module.typer.Typer()
    seen = []

    def stand_in(*given, **named):
        seen.append(signature(module.infer).bind(*given, **named).arguments)

    stand_in.__signature__ = signature(module.infer)
    stand_in.__annotations__ = module.infer.__annotations__
    app.command()(stand_in)

    def read(arguments):
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 0, result.output
        return dict(seen[-1])

    return read


@pytest.mark.parametrize(
    "line",
    [
        "a.jpg",
        "a.jpg b.jpg folder",
        "a.jpg --overwrite --threads 2",
        "-q -o out --format json,npz --format ply a.jpg",
        "--output out a.jpg -v --recursive --model edge --threads 256",
        "a.jpg --quiet -o one -o two",
    ],
)
def test_what_is_plain_is_read_as_typer_reads_it(line, by_typer):
    found = signature(module.infer).bind(**read_plain(line.split()))
    found.apply_defaults()
    assert {**found.arguments, "_version": None} == by_typer(line.split())


@pytest.mark.parametrize(
    "line",
    [
        "",
        "--help",
        "--version",
        "-",
        "-- a.jpg",
        "a.jpg --threads",
        "a.jpg --threads 0",
        "a.jpg --threads 257",
        "a.jpg --threads 2.0",
        "a.jpg -o",
        "a.jpg -o -q",
        "a.jpg --output=out",
        "a.jpg -qv",
        "a.jpg --threshold 0.4",
        "a.jpg --unknown",
        "--overwrite",
    ],
)
def test_everything_else_is_left_to_typer(line):
    assert read_plain(line.split()) is None


def test_a_usual_run_loads_no_typer(tiny_path, tmp_path, picture):
    from PIL import Image

    Image.fromarray(picture).save(tmp_path / "a.png")
    code = (
        "import sys; from footprints_edge.cli.start import infer; infer(); "
        "assert not {'typer', 'pydantic', 'rich'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, tmp_path / "a.png", "--model", tiny_path, "--threads", "1"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [str(tmp_path / "a.png.overlay.png")]


@pytest.mark.parametrize("line", ["a.png -o out.mcap", "a.mcap --format ply"])
def test_what_cannot_be_is_explained_as_typer_does(line, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "footprints_edge", *line.split()],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert "Usage" in done.stderr
