"""File names as OpenCV and FFmpeg can take them."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory


@contextmanager
def plain_name(path: Path) -> Iterator[str]:
    """Another name of a file, which need not exist yet.

    OpenCV crashes at names that are not UTF-8, and FFmpeg takes what stands before a colon for a
    protocol, unless a folder stands in front. A name that is not UTF-8 gets a link for as long as
    the context lasts; a file that is open then stays open.
    """
    name = str(path.absolute())
    if _is_utf8(name):
        yield name
        return
    with TemporaryDirectory(prefix="fp-") as folder:
        link = Path(folder, "video" + (path.suffix if _is_utf8(path.suffix) else ""))
        link.symlink_to(name)
        yield str(link)


def _is_utf8(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True
