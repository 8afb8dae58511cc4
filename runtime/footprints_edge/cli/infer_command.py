"""The command `fp-infer`: reads usual command lines itself, and leaves the others to typer."""

import sys

from footprints_edge.cli.exit_codes import OptionError
from footprints_edge.cli.plain_arguments import read_plain
from footprints_edge.cli.run_infer import run_infer


def main() -> None:
    """Runs `fp-infer`; see `start`."""
    plain = read_plain(sys.argv[1:])
    if plain is not None:
        try:
            run_infer(**plain)
        except OptionError:  # found before anything was done; typer explains it
            pass
        else:
            return
    from footprints_edge.cli.infer import app

    app()
