"""Peak memory of the largest pictures, each with all outputs, in a process of its own.

    python tests/fuzz/large_pictures.py [KIND ...]

Takes half a minute a picture and up to 600 MB of disk. Exit code 1 if one takes more than 1.5 GB.
"""

import resource
import struct
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path

MOST_BYTES = 1_500_000_000
SIDE = 13340
"""Squared just within the limit of 178 million pixels."""

JPEG_SIDE = 14310
"""Squared just within the limit of 205 million pixels for JPEG."""

_IN_MEMORY = """
import sys
import numpy as np
from PIL import Image
import footprints_edge as fp
kind, side, folder = sys.argv[1], int(sys.argv[2]), sys.argv[3]
if kind == "array":
    source = np.full((side, side, 3), 77, np.uint8)
elif kind == "pillow":
    source = Image.new("RGB", (side, side))
else:
    source = "examples/room.jpg"
prediction = fp.load(threads=1).predict(source)
if kind == "grid":
    prediction.top_down(0.01, 15)
else:
    prediction.save(folder, ["overlay", "npz", "png16", "json", "ply"], overwrite=True)
"""


def png(bits: int, colour: int, channels: int) -> bytes:
    """A black PNG, packed row after row, so that it takes no memory here."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    packer = zlib.compressobj(1)
    row = bytes(1 + (SIDE * bits * channels + 7) // 8)
    data = b"".join(packer.compress(row) for _ in range(SIDE)) + packer.flush()
    head = struct.pack(">IIBBBBB", SIDE, SIDE, bits, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def with_pillow(mode: str, side: int, **options: object) -> Callable[[Path], None]:
    """A writer of a picture of one colour."""

    def write(path: Path) -> None:
        from PIL import Image

        Image.new(mode, (side, side)).save(path, **options)

    return write


FILES: dict[str, tuple[str, Callable[[Path], object]]] = {
    "grey PNG": ("a.png", lambda path: path.write_bytes(png(1, 0, 1))),
    "RGB PNG": ("a.png", lambda path: path.write_bytes(png(8, 2, 3))),
    "RGBA PNG": ("a.png", lambda path: path.write_bytes(png(8, 6, 4))),
    "float TIFF": ("a.tif", with_pillow("F", SIDE, compression="tiff_adobe_deflate")),
    "uncompressed TIFF": ("a.tif", with_pillow("RGB", SIDE)),
    "BMP": ("a.bmp", with_pillow("RGB", SIDE)),
    "JPEG": ("a.jpg", with_pillow("RGB", JPEG_SIDE, quality=10)),
    "progressive JPEG": ("a.jpg", with_pillow("RGB", SIDE, quality=10, progressive=True)),
}
IN_MEMORY = ("array", "pillow", "grid")


def peak_bytes(command: list[str]) -> int:
    """The peak memory of a command.

    Raises:
        subprocess.CalledProcessError: If it fails.
    """
    code = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, "
        "stdout=subprocess.DEVNULL); "
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *command], check=True, stdout=subprocess.PIPE, text=True
    )
    return 1024 * int(done.stdout)


def main() -> int:
    """Prints a line for each kind."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kinds = sys.argv[1:] or [*FILES, *IN_MEMORY]
    worst = 0
    for kind in kinds:
        with tempfile.TemporaryDirectory(prefix="fp-large-") as folder:
            if kind in FILES:
                name, write = FILES[kind]
                write(Path(folder, name))
                formats = ["--format", "overlay,npz,png16,json,ply", "--bev", "-q", "-o", folder]
                command = ["-m", "footprints_edge", str(Path(folder, name)), *formats]
            else:
                command = ["-c", _IN_MEMORY, kind, str(SIDE), folder]
            peak = peak_bytes([sys.executable, *command])
        print(f"{kind}: {peak / 1e6:.0f} MB", flush=True)
        worst = max(worst, peak)
    return worst > MOST_BYTES


if __name__ == "__main__":
    sys.exit(main())
