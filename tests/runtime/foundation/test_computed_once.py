import threading

from footprints_edge.foundation.computed_once import computed_once


class Pair:
    """Two values; the second waits until another thread computes it, too."""

    def __init__(self, meeting):
        self.meeting, self.count = meeting, 0

    @computed_once
    def first(self):
        """Text for `help`."""
        self.count += 1
        return 1

    @computed_once
    def of_first(self):
        self.meeting.wait(5)
        return self.first + 1


def test_it_is_computed_once_and_can_be_replaced_like_an_attribute():
    pair = Pair(None)
    assert (pair.first, pair.first, pair.count) == (1, 1, 1)
    assert vars(pair)["first"] == 1
    del pair.first
    assert (pair.first, pair.count) == (1, 2)
    assert Pair.first.__doc__ == "Text for `help`."


def test_two_objects_in_two_threads_do_not_wait_for_each_other():
    meeting = threading.Barrier(2)
    pairs, found = (Pair(meeting), Pair(meeting)), []
    threads = [
        threading.Thread(target=lambda pair=pair: found.append(pair.of_first), daemon=True)
        for pair in pairs
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10)
    assert found == [2, 2]
