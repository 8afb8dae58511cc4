"""``fp-bench reduced-decoding``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import OneModel


def reduced_decoding_command(
    photos: Annotated[list[Path], typer.Argument(help="Image files.")],
    *,
    model: OneModel = None,
) -> None:
    """Measure how reduced JPEG decoding changes the maps.

    Each photo is enlarged to 12 million pixels and saved as a JPEG. The table, printed as Markdown,
    also shows how much the JPEG compression itself changes the maps.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.model import load
        from footprints_edge_bench.accuracy.reduced_decoding import as_markdown, decoding_effect

        loaded = load(model)
        effects = [decoding_effect(loaded, photo) for photo in photos]
        typer.echo(as_markdown(effects), nl=False)
