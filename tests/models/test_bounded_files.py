"""Files from anyone: what they state is no reason to take memory."""

import io
import struct
import zipfile
import zlib

import numpy as np
import pytest
from PIL import Image

from footprints_edge_models import bounded_files
from footprints_edge_models.bounded_files import (
    decode_picture,
    read_array,
    read_arrays,
    refuse_packed,
)


def zipped(files, kind=zipfile.ZIP_DEFLATED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", kind) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return buffer.getvalue()


def png_of(width, height):
    """A PNG that states a size; its pixels are missing."""

    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


def saved(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def test_arrays_are_read_from_bytes_and_from_a_path(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", x=np.arange(5), name=np.array("room"))
    for file in (tmp_path / "a.npz", (tmp_path / "a.npz").read_bytes()):
        arrays = read_arrays(file)
        assert arrays["x"].tolist() == [0, 1, 2, 3, 4]
        assert str(arrays["name"]) == "room"
    np.save(tmp_path / "b.npy", np.arange(3))
    assert read_array(tmp_path / "b.npy").tolist() == [0, 1, 2]


def test_what_unpacks_to_too_much_is_refused(monkeypatch):
    monkeypatch.setattr(bounded_files, "MOST_BYTES", 10_000)
    with pytest.raises(ValueError, match="unpacks to 200256 bytes"):
        read_arrays(zipped({"a.npy": saved(np.zeros(10_000)), "b.npy": saved(np.zeros(15_000))}))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04 nothing",
        zipped({"a.npy": b"\x93NUMPY no header"}),
        zipped({"a.txt": b"no array"}),
        zipped({"a.npy": saved(np.array([{}], object))}),
        zipped({"a.npy": saved(np.zeros(3)).replace(b"(3,)", b"(9e99,)")}),
        zipped({"a.npy": saved(np.zeros(3)).replace(b"(3,), }    ", b"(10**15,),}")}),
    ],
)
def test_no_arrays_are_refused_in_one_way(data):
    with pytest.raises(ValueError, match="no readable arrays"):
        read_arrays(data)


def test_a_huge_stated_array_is_refused():
    stated = saved(np.zeros(3)).replace(b"(3,), }" + b" " * 12, b"(3000000000000,), }")
    assert b"3000000000000" in stated
    with pytest.raises(ValueError, match="no readable array"):
        read_array(stated)


def test_pictures_are_decoded_and_bombs_and_rubbish_are_not():
    buffer = io.BytesIO()
    Image.new("RGB", (4, 2), (200, 100, 50)).save(buffer, "PNG")
    assert decode_picture(buffer.getvalue())[0, 0].tolist() == [50, 100, 200]
    for data in (b"", b"no picture", png_of(30_000, 30_000), png_of(13_000, 13_800)):
        with pytest.raises(ValueError, match="not a readable picture"):
            decode_picture(data)


def test_a_zip_that_packs_is_refused_where_all_is_stored(tmp_path):
    path = tmp_path / "a.zip"
    path.write_bytes(zipped({"zeros": bytes(10**6)}))
    with pytest.raises(ValueError, match="unpacks to 1000000 bytes"):
        refuse_packed(path)
    path.write_bytes(zipped({"zeros": bytes(10**6)}, zipfile.ZIP_STORED))
    refuse_packed(path)
