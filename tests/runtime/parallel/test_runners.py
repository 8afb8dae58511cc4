"""Many items in this process and in others: every item has one outcome, whatever happens."""

import importlib
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from footprints_edge.parallel import processes
from footprints_edge.parallel.job import in_runs
from footprints_edge.parallel.processes import DIED_TWICE, run_in_processes
from footprints_edge.parallel.serial import run_serially

RUNNERS = {
    "serial": run_serially,
    "one process": partial(run_in_processes, processes=1),
    "two processes": partial(run_in_processes, processes=2),
    "item by item": partial(run_in_processes, processes=2, run_length=1),
}


@pytest.fixture
def squares(monkeypatch):
    """The class of stand-in jobs, where worker processes find it too."""
    monkeypatch.syspath_prepend(Path(__file__).parent)
    return importlib.import_module("scripted_job").Squares


@pytest.fixture(params=list(RUNNERS))
def runner(request):
    return RUNNERS[request.param]


def run(runner, job, items):
    outcomes = []
    runner(job, items, outcomes.append)
    assert sorted(outcome.item for outcome in outcomes) == sorted(items)
    return {outcome.item: outcome for outcome in outcomes}


def states(outcomes):
    return Counter(outcome.state for outcome in outcomes.values())


def test_every_item_is_done_once(runner, squares, tmp_path):
    job = squares(tmp_path)
    outcomes = run(runner, job, range(6))
    assert {item: outcome.result for item, outcome in outcomes.items()} == {
        item: item**2 for item in range(6)
    }
    assert states(outcomes) == {"done": 6}
    assert sorted(job.begun()) == list(range(6))
    assert job.starts() <= 2


def test_finished_items_are_kept_and_not_done_again(runner, squares, tmp_path):
    (tmp_path / "2.txt").write_text("40")
    job = squares(tmp_path)
    outcomes = run(runner, job, range(4))
    assert (outcomes[2].state, outcomes[2].result) == ("kept", 40)
    assert sorted(job.begun()) == [0, 1, 3]
    assert states(run(runner, job, range(4))) == {"kept": 4}
    assert sorted(job.begun()) == [0, 1, 3]


def test_an_item_that_fails_costs_only_itself(runner, squares, tmp_path):
    outcomes = run(runner, squares(tmp_path, fails_at=(1,), crashes_at=(2,)), range(5))
    assert states(outcomes) == {"done": 3, "failed": 2}
    assert outcomes[1].reason == "no file for 1"
    assert outcomes[2].reason == "ZeroDivisionError: what nobody thought of"
    assert outcomes[1].result is None


def test_no_items_start_no_worker(runner, squares, tmp_path):
    job = squares(tmp_path)
    assert run(runner, job, []) == {}
    assert job.starts() == 0


@pytest.mark.parametrize("name", ["one process", "item by item"])
def test_a_killed_worker_is_replaced(name, squares, tmp_path):
    job = squares(tmp_path, dies_once_at=(1,), dies_at=(3,))
    outcomes = run(RUNNERS[name], job, range(6))
    assert states(outcomes) == {"done": 5, "failed": 1}
    assert outcomes[3].reason == DIED_TWICE
    assert Counter(job.begun()) == Counter([*range(6), 1, 3])


def test_what_a_killed_worker_had_finished_is_not_done_again(squares, tmp_path):
    job = squares(tmp_path, dies_late_at=(1,))
    outcomes = run(RUNNERS["one process"], job, range(3))
    assert states(outcomes) == {"done": 3}
    assert job.begun() == [0, 1, 2]


def test_each_process_takes_one_contiguous_part(squares, tmp_path):
    job = squares(tmp_path)
    run(RUNNERS["two processes"], job, range(7))
    assert job.by_process() == [[0, 1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(("count", "parts"), [(0, 3), (2, 5), (7, 3), (9, 3), (10, 4)])
def test_runs_are_contiguous_and_about_equal(count, parts):
    items = list(range(count))
    runs = list(in_runs(items, parts))
    assert [item for part in runs for item in part] == items
    assert len(runs) == min(parts, count)
    lengths = [len(part) for part in runs] or [0]
    assert max(lengths) - min(lengths) <= 1


def test_a_worker_that_dies_between_two_items_costs_none(squares, tmp_path, monkeypatch):
    """As one does that the system ends while it waits for work."""
    advance, died = processes._Lane._advance, []

    def advance_and_die(lane):
        advance(lane)
        if not died and lane._waiting:
            (pid,) = lane._pool._processes
            died.append(pid)
            os.kill(pid, signal.SIGKILL)
            while not lane._pool._broken:
                time.sleep(0.01)

    monkeypatch.setattr(processes._Lane, "_advance", advance_and_die)
    job = squares(tmp_path)
    outcomes = run(partial(run_in_processes, processes=1), job, range(4))
    assert died
    assert states(outcomes) == {"done": 4}
    assert sorted(job.begun()) == list(range(4))


PARENT = """
import sys
sys.path.insert(0, {here!r})
from pathlib import Path
from footprints_edge.parallel.processes import run_in_processes
from scripted_job import Squares
if __name__ == "__main__":
    job = Squares(Path({folder!r}), waits_at=(0, 1))
    run_in_processes(job, range(4), print, processes=2, run_length=1)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="kills as POSIX does")
def test_workers_end_when_their_parent_is_killed(squares, tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(PARENT.format(here=str(Path(__file__).parent), folder=str(tmp_path)))
    parent = subprocess.Popen([sys.executable, script])
    job = squares(tmp_path)
    until(lambda: len(job.begun()) == 2)
    workers = [int(pid) for pid in job.pids()]
    parent.kill()
    parent.wait()
    until(lambda: not any(map(runs, workers)))


def until(happens, within_s=60):
    end = time.monotonic() + within_s
    while not happens():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.1)


def runs(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{pid}/stat")  # who inherits orphans may not wait for them
    return not (status.exists() and status.read_text().rpartition(")")[2].split()[0] == "Z")
