import gc
import threading

import pytest

from footprints_edge.parallel import in_order
from footprints_edge.parallel.in_order import PredictionIterator


def test_results_come_in_order_though_a_later_item_is_done_first():
    done = threading.Event()

    def work(item):
        if item == 0:
            assert done.wait(20)
        else:
            done.set()
        return item

    assert list(PredictionIterator(work, range(5), 2)) == [0, 1, 2, 3, 4]


def test_no_more_than_two_items_a_worker_are_taken_in_advance():
    taken = []
    results = PredictionIterator(lambda item: item, (taken.append(i) or i for i in range(50)), 2)
    next(results)
    assert len(taken) == 4
    results.close()
    assert list(results) == []


def test_an_item_that_never_ends_is_left_behind():
    never, begun = threading.Event(), threading.Event()

    def work(item):
        if item == 1:
            begun.set()
            never.wait()
        return item

    results = PredictionIterator(work, range(9), 2)
    assert next(results) == 0
    assert begun.wait(20)
    finished = results.stop(0.2)
    assert finished == sorted(finished)
    assert 1 not in finished
    with pytest.raises(StopIteration):
        next(results)
    never.set()


def test_threads_end_when_nobody_takes_the_rest():
    before = set(threading.enumerate())
    results = PredictionIterator(lambda item: item, range(50), 2)
    next(results)
    ours = set(threading.enumerate()) - before
    assert len(ours) == 2
    del results
    gc.collect()
    for thread in ours:
        thread.join(20)
    assert not any(thread.is_alive() for thread in ours)


@pytest.mark.parametrize("most", [0, 1])
def test_where_no_more_threads_are_to_be_had_those_that_are_do_the_work(most, monkeypatch):
    begun = []

    class Scarce(threading.Thread):
        def start(self):
            if len(begun) == most:
                raise RuntimeError("can't start new thread")
            begun.append(self)
            super().start()

    def ratio(number):
        return number / (number - 3)

    monkeypatch.setattr(in_order, "Thread", Scarce)
    results = PredictionIterator(ratio, range(8), 3)
    assert [next(results) for _ in range(3)] == [0, -1 / 2, -2]
    with pytest.raises(ZeroDivisionError):
        next(results)
    assert list(results) == [4, 5 / 2, 2, 7 / 4]
    in_order._join_all()
