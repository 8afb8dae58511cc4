"""``fp-bench frame``."""

from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import OneModel, Threads


def frame_command(
    *,
    model: OneModel = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each kind.")] = 40,
    photos: Annotated[int, typer.Option(min=0, help="Photos in the folder; 0 for none.")] = 500,
) -> None:
    """Measure what a whole frame costs beside its network.

    Arrays, a phone's JPEG, and a folder of photos. Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.model import load
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.whole_frame import whole_frame

        facts = machine()
        found = whole_frame(load(model, threads=threads), model or "", trials, photos)
        typer.echo(found.as_markdown() + "\n" + facts.as_markdown())
