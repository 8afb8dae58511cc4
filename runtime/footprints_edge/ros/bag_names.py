"""Which inputs are bags, and the names of what is written for them."""

from pathlib import Path

BAG_SUFFIXES = frozenset({".mcap", ".bag", ".db3"})

WRITTEN_SUFFIXES = (".mcap", ".bag")
"""Bags that are written: of ROS 2, and of ROS 1."""

_ENDING = ".ground"


def is_bag(named: str) -> bool:
    """Whether a command-line argument names a bag: a file, or a folder of ROS 2."""
    if Path(named).suffix.lower() in BAG_SUFFIXES:
        return True
    try:
        with (Path(named) / "metadata.yaml").open("rb") as file:
            return b"rosbag2_bagfile_information" in file.read(4096)
    except (OSError, ValueError):  # such as a name that is too long for a file
        return False


def names_file(output: Path | None) -> bool:
    """Whether `--output` names the bag to write, and not a folder."""
    return output is not None and output.suffix.lower() in WRITTEN_SUFFIXES and not output.is_dir()


def written_bag(source: Path, output: Path | None) -> Path:
    """The bag that is written for another.

    Args:
        source: The bag that is read.
        output: The bag to write, a folder, or None for that of `source`.
    """
    if output is not None and names_file(output):
        return output
    if source.name in {"", ".."}:
        source = source.resolve()
    suffix = ".bag" if source.suffix.lower() == ".bag" else ".mcap"
    return (output or source.parent) / (source.name + _ENDING + suffix)


def partial_bag(path: Path) -> Path:
    """The name of a bag until it is whole."""
    return path.with_name(f"{path.stem}.partial{path.suffix}")
