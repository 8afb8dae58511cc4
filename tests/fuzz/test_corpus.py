"""Files that once failed, tried again; and the fuzzing itself."""

import io
import sys
from pathlib import Path

import pytest
import run
import targets

CORPUS = Path(__file__).parent / "corpus"
FILES = sorted(path for path in CORPUS.glob("*/*") if path.is_file())


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_once_failed_holds(path):
    targets.TARGETS[path.parent.name].check(path.read_bytes())


def test_every_kind_is_fuzzed():
    assert set(run.KINDS) == set(targets.TARGETS)
    assert {path.parent.name for path in FILES} <= set(run.KINDS)


@pytest.mark.parametrize("seed", [*targets.CALIBRATIONS, *targets.SEQUENCES])
def test_the_sound_files_are_sound(seed, monkeypatch):
    """Otherwise only refusals would be tried."""
    refused = []
    monkeypatch.setattr(targets, "typed_errors", lambda: _Counting(refused))
    kind = "calibrations" if seed in targets.CALIBRATIONS else "sequences"
    targets.TARGETS[kind].check(seed.encode())
    assert [str(error) for error in refused if "rgb.mp4" not in str(error)] == []


class _Counting:
    def __init__(self, refused):
        self.refused = refused

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if error is not None:
            self.refused.append(error)
        return isinstance(error, targets.FootprintsError)


def test_a_failure_is_kept_as_small_as_it_gets(tmp_path, monkeypatch, capsys):
    def check(data):
        if b"nan" in data:
            raise KeyError("found")

    spoiled = targets.TARGETS["calibrations"].spoiled
    monkeypatch.setitem(targets.TARGETS, "calibrations", targets.Target(check, spoiled))
    monkeypatch.setattr(run, "EXAMPLES", 300)
    assert run.work("calibrations", 0, 0, tmp_path) == run._FAILED
    assert "KeyError: 'found'" in capsys.readouterr().out
    (kept,) = (tmp_path / "calibrations").iterdir()
    assert kept.read_bytes().count(b"nan") == 1


def test_a_process_that_dies_has_failed(tmp_path, monkeypatch, capfd):
    script = "import pathlib, sys; pathlib.Path(sys.argv[1]).write_bytes(b'deadly'); sys.exit(1)"
    monkeypatch.setattr(
        run, "worker", lambda kind, *_: [sys.executable, "-c", script, tmp_path / f".last-{kind}"]
    )
    assert not run.watched("exif", 0, 0, tmp_path)
    (kept,) = (tmp_path / "exif").iterdir()
    assert kept.read_bytes() == b"deadly"
    assert "the process ended with 1" in capfd.readouterr().out


def test_pictures_to_spoil_are_pictures():
    for kind in ("PNG", "JPEG", "WEBP", "BMP", "TIFF"):
        with targets.Image.open(io.BytesIO(targets.saved("RGB", kind))) as image:
            assert image.size == (40, 24)
