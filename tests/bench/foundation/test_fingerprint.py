"""Fingerprints of files change with what they stand for."""

import os

from footprints_edge_bench.foundation.fingerprint import fingerprint


def test_name_size_and_time_count(tmp_path):
    path = tmp_path / "a"
    path.write_text("one")
    os.utime(path, ns=(10**18, 10**18))
    first = fingerprint([path])
    assert fingerprint([path]) == first
    (tmp_path / "elsewhere").mkdir()
    moved = tmp_path / "elsewhere" / "a"
    moved.write_text("two")
    os.utime(moved, ns=(10**18, 10**18))
    assert fingerprint([moved]) == first  # neither its folder nor its content is looked at
    os.utime(path, ns=(10**18, 10**18 + 1))
    assert fingerprint([path]) != first
    moved.write_text("three")
    os.utime(moved, ns=(10**18, 10**18))
    assert fingerprint([moved]) != first
    assert fingerprint([path.rename(tmp_path / "b")]) != first


def test_a_missing_file_differs_from_one_that_is_there(tmp_path):
    before = fingerprint([tmp_path / "a"])
    (tmp_path / "a").touch()
    assert fingerprint([tmp_path / "a"]) != before
