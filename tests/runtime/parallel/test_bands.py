import os
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge.parallel.bands import at_once, bands, on_bands


@given(st.integers(1, 500), st.integers(1, 9), st.integers(1, 7))
def test_bands_cover_everything_once_in_order(length, parts, multiple):
    found = bands(length, parts, multiple)
    assert [i for band in found for i in range(length)[band]] == list(range(length))
    assert 1 <= len(found) <= parts
    assert all((band.stop - band.start) % multiple == 0 for band in found[:-1])
    sizes = [-(-(band.stop - band.start) // multiple) for band in found]
    assert max(sizes) - min(sizes) <= 1


def test_bands_are_worked_on_at_once():
    barrier = threading.Barrier(3, timeout=20)
    assert on_bands(lambda band: barrier.wait() >= 0 and band.start, bands(6, 3)) == [0, 2, 4]


def test_an_error_in_a_band_reaches_the_caller():
    def work(band):
        if band.start:
            raise ValueError(band.start)

    with pytest.raises(ValueError, match="2"):
        on_bands(work, bands(4, 2))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_starts_threads_of_its_own():
    on_bands(lambda band: band.start, bands(4, 2))
    child = os.fork()
    if child == 0:
        os._exit(0 if on_bands(lambda band: band.start, bands(4, 2)) == [0, 2] else 1)
    for _ in range(200):
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        threading.Event().wait(0.1)
    else:
        os.kill(child, 9)
        os.waitpid(child, 0)
        pytest.fail("the forked process waits for threads that it does not have")
    assert status == 0


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_functions_at_once_give_their_results_in_order(count):
    assert at_once([lambda i=i: i for i in range(count)]) == list(range(count))
