import os
import subprocess
import sys
from pathlib import Path

import pytest

from footprints_edge.foundation import parts
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.foundation.parts import new_part, part_folder, remove_abandoned

WRITER = """
import sys, time
from pathlib import Path
from footprints_edge.foundation.parts import new_part
file, folder = (new_part(Path(sys.argv[1])) for _ in range(2))
file.touch()
folder.mkdir()
(folder / "inside").touch()
print("ready", flush=True)
time.sleep(60)
"""


def hidden(folder):
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


@pytest.fixture
def writer(tmp_path):
    """A process that has a file and a folder under way in `tmp_path`."""
    process = subprocess.Popen([sys.executable, "-c", WRITER, tmp_path], stdout=subprocess.PIPE)
    assert process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


@pytest.fixture
def another_process(monkeypatch):
    """This process as if it had written nothing yet."""
    monkeypatch.setattr(parts, "_swept", set())


@pytest.mark.usefixtures("another_process")
def test_the_next_write_removes_what_a_killed_process_left(tmp_path, writer):
    assert len(hidden(tmp_path)) == 2
    writer.kill()
    writer.wait()
    write_atomically(tmp_path / "a.txt", b"whole")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.usefixtures("another_process")
def test_what_a_living_process_is_at_stays(tmp_path, writer):
    before = hidden(tmp_path)
    write_atomically(tmp_path / "a.txt", b"whole")
    assert hidden(tmp_path) == before
    assert writer.poll() is None


def test_a_process_sweeps_a_folder_once(tmp_path, monkeypatch):
    swept = []
    monkeypatch.setattr(parts, "remove_abandoned", swept.append)
    monkeypatch.chdir(tmp_path)
    for folder in (tmp_path, tmp_path / ".", Path()):
        new_part(folder)
    assert swept == [tmp_path]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_fork_sweeps_anew_and_has_names_of_its_own(tmp_path, writer):
    mine = new_part(tmp_path).name.split("-")
    writer.kill()
    writer.wait()
    child = os.fork()
    if not child:
        try:
            write_atomically(tmp_path / "of.child", new_part(tmp_path).name.encode())
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    theirs = (tmp_path / "of.child").read_text().split("-")
    assert hidden(tmp_path) == []
    assert mine[1] == theirs[1] and mine[2] == str(os.getpid()) and theirs[2] == str(child)


def test_parts_of_other_machines_and_foreign_names_stay(tmp_path, writer):
    writer.kill()
    writer.wait()
    for path in list(tmp_path.iterdir()):
        machine = path.name.split("-")[1]
        other = f"{int(machine, 16) ^ 1:08x}"
        path.rename(path.with_name(path.name.replace(machine, other)))
    foreign = [".part", ".fp-1-2.part", ".fp-export-abc", ".notes.part", "fp-a-1-1-a.part"]
    for name in foreign:
        (tmp_path / name).touch()
    remove_abandoned(tmp_path)
    assert len(list(tmp_path.iterdir())) == 2 + len(foreign)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="start times are Linux's")
def test_a_process_that_has_the_number_of_a_dead_one_keeps_nothing_alive(tmp_path):
    path = new_part(tmp_path)
    started = path.name.split("-")[3]
    (tmp_path / path.name.replace(f"-{started}-", f"-{int(started) - 1}-")).touch()
    path.touch()
    remove_abandoned(tmp_path)
    assert hidden(tmp_path) == [path.name]
    # a process that no longer knows, as where /proc is not to be had, has to keep both
    unknown = tmp_path / path.name.replace(f"-{started}-", "-0-")
    unknown.touch()
    remove_abandoned(tmp_path)
    assert unknown.exists()


def test_folders_that_cannot_be_read_and_links_are_no_error(tmp_path, writer):
    remove_abandoned(tmp_path / "none")
    remove_abandoned(tmp_path / "a\0b")
    writer.kill()
    writer.wait()
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "inside").touch()
    (folder,) = (path for path in tmp_path.glob(".fp-*") if path.is_dir())
    for each in folder.iterdir():
        each.unlink()
    folder.rmdir()
    folder.symlink_to(kept, target_is_directory=True)
    remove_abandoned(tmp_path)
    assert hidden(tmp_path) == [] and (kept / "inside").exists()


def test_a_folder_is_there_until_it_is_renamed_or_fails(tmp_path):
    with part_folder(tmp_path) as part:
        (part / "a").touch()
        part.rename(tmp_path / "done")
    with pytest.raises(KeyboardInterrupt), part_folder(tmp_path) as part:
        (part / "a").touch()
        raise KeyboardInterrupt
    assert [path.name for path in tmp_path.iterdir()] == ["done"]


def test_what_earlier_versions_left_goes_after_a_day(tmp_path):
    old, fresh = tmp_path / ".fp-12728-140230367639232.part", tmp_path / ".fp-12728-7.part"
    for part in (old, fresh):
        part.touch()
    os.utime(old, (0, 0))
    remove_abandoned(tmp_path)
    assert hidden(tmp_path) == [fresh.name]
