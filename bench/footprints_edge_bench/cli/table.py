"""``fp-bench table``."""

from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, explained
from footprints_edge_bench.cli.options import (
    EDGE_CHECKPOINT,
    CacheFolder,
    EdgeCheckpoint,
    JsonFile,
    Threads,
)


def table_command(
    *,
    output: JsonFile = None,
    presets: Annotated[
        list[str] | None,
        typer.Option(
            "--preset", help="kitti, handheld or matterport; repeatable.  [default: all three]"
        ),
    ] = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames per row.")] = 30,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: CacheFolder = None,
) -> None:
    """Print the paper's speed table with our rows.

    The paper's rows are quoted, ours are measured on this machine, and so are networks of the
    shape of its peers. Prints Markdown.

    Exit codes: 0 done, 1 some rows cannot run, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.engines.backend import BackendSetting
        from footprints_edge_bench.latency.backends import PRESETS
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.paper_table import speed_table
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        cached = ModelCache(cache or default_folder(), edge_checkpoint)
        setting = BackendSetting(cached, threads or usable_cores())
        found = speed_table(setting, machine(), trials, presets or tuple(PRESETS))
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)
        reasons = [row.reason for row in found.rows] + [row.reason for row in found.peers]
        if any(reasons):
            raise typer.Exit(SOME_FAILED)
