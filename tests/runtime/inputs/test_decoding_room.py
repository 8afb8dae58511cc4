from threading import Event, Thread

from footprints_edge.inputs.decoding_room import DecodingRoom


def test_large_pictures_wait_for_each_other_and_small_ones_do_not():
    room = DecodingRoom(100)
    entered, leave = [], Event()

    def decode(pixels):
        with room.taken(pixels):
            entered.append(pixels)
            assert leave.wait(10)

    def begun(pixels):
        thread = Thread(target=decode, args=[pixels])
        thread.start()
        thread.join(0.1)
        return thread

    threads = [begun(pixels) for pixels in (60, 40, 1, 500)]
    assert entered == [60, 40]
    leave.set()
    for thread in threads:
        thread.join(10)
    assert sorted(entered) == [1, 40, 60, 500]
    with room.taken(500):
        assert room.pixels == 100
