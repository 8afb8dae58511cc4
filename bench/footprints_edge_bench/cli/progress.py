"""The progress bar of the commands."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(total: int, unit: str) -> Iterator[Callable[[str], None]]:
    """Shows a progress bar on stderr, if that is a terminal.

    Args:
        total: number of steps.
        unit: what a step is, in the singular.

    Yields:
        A function to call with the name of each step when it is done.
    """
    from tqdm import tqdm

    with tqdm(total=total, unit=unit, disable=None) as bar:

        def advance(name: str) -> None:
            bar.set_postfix_str(name, refresh=False)
            bar.update()

        yield advance
