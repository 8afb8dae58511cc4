"""``fp-bench video``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import JsonFile, OneModel


def video_command(
    video: Annotated[Path, typer.Argument(help="A video file.")],
    *,
    output: JsonFile = None,
    model: OneModel = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Number of threads to use.  [default: all usable cores]"),
    ] = None,
    length: Annotated[
        int,
        typer.Option(
            min=400, help="Number of frames for each row; the video is repeated to reach it."
        ),
    ] = 2000,
) -> None:
    """Measure throughput and memory of fp-infer on a video.

    Throughput is compared with that of inference alone. Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.temporal.video_throughput import measure_video

        found = measure_video(video, model, threads or usable_cores(), length)
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)
