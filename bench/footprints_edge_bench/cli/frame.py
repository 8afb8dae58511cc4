"""``fp-bench frame``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import OneModel, Threads


def frame_command(
    photo: Annotated[Path, typer.Argument(help="A photo that shows ground.")],
    *,
    before: Annotated[
        Path | None,
        typer.Option(help="Checkout of another version, to measure it in turns with this one."),
    ] = None,
    model: OneModel = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each kind.")] = 40,
    starts: Annotated[int, typer.Option(min=2, help="Fresh processes of each kind.")] = 20,
    photos: Annotated[int, typer.Option(min=0, help="Photos in the folder; 0 for none.")] = 500,
) -> None:
    """Measure what a whole frame costs beside its network.

    Arrays, a phone's JPEG, a start of fp-infer, and a folder of photos. Prints a table as
    Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge.inputs.images import decode
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.whole_frame import as_markdown, whole_frame

        facts = machine()
        runtimes = {} if before is None else {"before": before.absolute()}
        found = whole_frame(
            {**runtimes, "here": None},
            decode(photo).rgb,
            model or "",
            threads=threads or usable_cores(),
            trials=trials,
            starts=starts,
            photos=photos,
        )
        typer.echo(as_markdown(found) + "\n" + facts.as_markdown())
