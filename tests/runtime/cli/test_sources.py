import pytest

from footprints_edge.cli.sources import InputImage, expand
from footprints_edge.errors import ImageError
from footprints_edge.outputs.writers import FORMATS


@pytest.fixture
def folder(tmp_path):
    for name in ("b.PNG", "a.jpg", "notes.txt", ".hidden.jpg", "sub/c.webp", "sub/deep/d.tif"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    for files in FORMATS.values():
        for suffix in files:
            (tmp_path / f"a.jpg{suffix}").touch()
    (tmp_path / "folder.jpg").mkdir()
    return tmp_path


def test_the_pictures_of_a_folder_without_our_outputs(folder):
    assert [source.path.name for source in expand(str(folder))] == ["a.jpg", "b.PNG"]


def test_sub_folders_are_remembered(folder):
    found = {str(s.path.name): str(s.subfolder) for s in expand(str(folder), recursive=True)}
    assert found == {"a.jpg": ".", "b.PNG": ".", "c.webp": "sub", "d.tif": "sub/deep"}


def test_a_named_file_is_always_tried(folder):
    for name in ("notes.txt", "a.jpg.overlay.png", "nowhere.jpg"):
        assert expand(str(folder / name)) == [InputImage(folder / name)]


def test_standard_input():
    (source,) = expand("-")
    assert (source.path, source.name, source.label) == (None, "stdin", "standard input")


def test_a_folder_without_pictures_is_explained(folder):
    with pytest.raises(ImageError, match=r"no picture.*--recursive"):
        expand(str(folder / "folder.jpg"))
