"""Reads the usual command lines of `fp-infer` without typer.

Its conversion of values loads pydantic, which takes as long as numpy and onnxruntime. What is not
plain is left to typer, and so is every mistake, for its message.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

_FLAGS = {
    **dict.fromkeys(("-q", "--quiet"), "quiet"),
    **dict.fromkeys(("-v", "--verbose"), "verbose"),
    "--recursive": "recursive",
    "--overwrite": "overwrite",
}
_THREADS = frozenset(map(str, range(1, 257)))


def read_plain(arguments: Sequence[str]) -> dict[str, Any] | None:
    """The arguments of the function `infer`, as typer would pass them.

    Args:
        arguments: The command line, without the command's name.

    Returns:
        What is given; None if typer has to read it.
    """
    images: list[str] = []
    formats: list[str] = []
    found: dict[str, Any] = {}
    rest = iter(arguments)
    for argument in rest:
        if argument in _FLAGS:
            found[_FLAGS[argument]] = True
        elif argument in {"-o", "--output", "--format", "--model", "--threads"}:
            value = next(rest, "-")
            if value.startswith("-"):
                return None
            if argument == "--format":
                formats.append(value)
            elif argument == "--model":
                found["model"] = value
            elif argument != "--threads":
                found["output"] = Path(value)
            elif value in _THREADS:
                found["threads"] = int(value)
            else:
                return None
        elif argument.startswith("-"):
            return None
        else:
            images.append(argument)
    if not images or any(map(_expanded, arguments)):
        return None
    return {"images": images, **found, **({"formats": formats} if formats else {})}


def _expanded(argument: str) -> bool:
    """Whether typer makes something else of an argument, as it does where the shell does not."""
    return sys.platform == "win32" and not set(argument).isdisjoint("*?[~$%")
