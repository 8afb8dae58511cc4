"""``fp-train pack``: datasets decoded once, for training."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained


def pack(
    data: Annotated[Path, typer.Argument(help="Folder of the datasets (see docs/data.md).")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the packed datasets.")],
) -> None:
    """Decode every dataset found in DATA once, and write it for training from memory-mapped files.

    Name the folder in place of DATA. About 1.3 MB a picture of 512x288. Datasets that the folder
    has already are kept: an interrupted command goes on with the next one.
    """
    with explained("train"):
        from footprints_edge_models.data.mixture import load_datasets
        from footprints_edge_models.data.packed import pack as write

        for index in write(load_datasets(data), output):
            typer.echo(index)
