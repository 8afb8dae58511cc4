"""`fp-infer`: pictures in, walkable ground in metres out."""

import sys
import warnings
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained, show_version
from footprints_edge.errors import FootprintsError, ImageError

if TYPE_CHECKING:
    from footprints_edge.cli.batch import Batch, Task
    from footprints_edge.maps.ground_maps import GroundMaps
    from footprints_edge.model import Camera, Model
    from footprints_edge.outputs.writers import Encoder
    from footprints_edge.prediction import Prediction

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def infer(
    images: Annotated[
        list[str],
        typer.Argument(
            help="Pictures, folders of pictures, - for standard input; videos, rtsp://…, camera:0."
        ),
    ],
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", help="Folder for the results, instead of beside each picture."
        ),
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            help="overlay (if not given), npz, png16, json, ply, topdown, topdown_picture; several "
            "with commas. Of videos: overlay, json.",
        ),
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="Model file, or a name that fp-models list shows.")
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Threads, instead of one for each usable core."),
    ] = None,
    threshold: Annotated[
        float, typer.Option(min=0, max=1, help="Probability above which a pixel is ground.")
    ] = 0.5,
    fx: Annotated[float | None, typer.Option(help="Focal length along x, in pixels.")] = None,
    fy: Annotated[float | None, typer.Option(help="Focal length along y, in pixels.")] = None,
    cx: Annotated[float | None, typer.Option(help="Principal point, if not the centre.")] = None,
    cy: Annotated[float | None, typer.Option(help="Principal point, if not the centre.")] = None,
    hfov: Annotated[
        float | None, typer.Option(help="Horizontal field of view in degrees, instead of fx, fy.")
    ] = None,
    path: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="X0,Y0 X1,Y1",
            help="Plan a path between two pixels of the picture, and draw it to .path.png.",
        ),
    ] = None,
    margin: Annotated[
        float, typer.Option(min=0, help="Metres that the path keeps from obstacles.")
    ] = 0.0,
    every: Annotated[
        int, typer.Option(min=1, help="Of a video: look at every so manieth frame only.")
    ] = 1,
    max_fps: Annotated[
        float | None, typer.Option(help="Of a video: look at so many frames a second at most.")
    ] = None,
    raw: Annotated[
        str | None,
        typer.Option(
            metavar="WxH[@FPS]",
            help="Standard input holds raw RGB frames of this size: ffmpeg … | fp-infer - --raw …",
        ),
    ] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="Of a video: keep the maps steady.")
    ] = False,
    panel: Annotated[
        bool, typer.Option("--panel", help="Show the ground from above beside the overlay.")
    ] = False,
    recursive: Annotated[
        bool, typer.Option("--recursive", help="Look into the sub-folders of folders.")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace results that are there already.")
    ] = False,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="No progress, no notes; results and errors only.")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("-v", "--verbose", help="Say a line about each picture.")
    ] = False,
    _version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Find the walkable ground in pictures and videos, seen and hidden, and its distance in metres.

    Prints the files that it wrote. Exit codes: 0 all done, 1 some pictures failed,
    2 wrong usage, 3 problem with the model.
    """
    with explained():
        from footprints_edge.cli.batch import plan
        from footprints_edge.model_files.registry import resolve

        warnings.filterwarnings("ignore", module=r"PIL\.")  # what matters arrives as ImageError
        camera = _camera(fx, fy, cx, cy, hfov)
        wanted = [part.strip() for text in formats or ["overlay"] for part in text.split(",")]
        extra = {".path.png": _path_encoder(path, margin)} if path else {}
        if panel and "overlay" in wanted:
            extra[".overlay.png"] = _overlay_with_panel
        videos = _videos_among(images, raw)
        pictures = [name for name in images if name not in videos]
        if videos and path:
            raise typer.BadParameter("--path is for pictures: its pixels are those of one frame")
        if not videos and (smooth or every != 1 or max_fps is not None):
            raise typer.BadParameter("--every, --max-fps and --smooth are for videos")
        if videos:
            from footprints_edge.video.capture import Pace, RawFormat

            pace = Pace(every, max_fps)
            layout = RawFormat.parse(raw) if raw else None
        batch = plan(
            pictures, wanted, output, recursive=recursive, overwrite=overwrite, extra=extra
        )
        resolve(model)  # a wrong name shows even where there is nothing to do
        if batch.tasks:
            from footprints_edge.model import load

            loaded = load(model, threads=threads)
            _work(batch, loaded, camera, threshold, quiet=quiet, verbose=verbose)
            del loaded
        if videos:
            from footprints_edge.cli.infer_video import VideoOptions, infer_videos
            from footprints_edge.foundation.cores import usable_cores
            from footprints_edge.model import load

            options = VideoOptions(
                pace,
                layout,
                smooth,
                panel,
                wanted,
                threads or usable_cores(),
                output,
                overwrite=overwrite,
                quiet=quiet,
            )
            infer_videos(videos, options, load(model, threads=1), camera, threshold, batch)
        _close(batch, quiet=quiet)


def main() -> None:
    """Entry point of `fp-infer`."""
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="surrogateescape")  # file names need not be valid UTF-8
    app()


def _camera(
    fx: float | None, fy: float | None, cx: float | None, cy: float | None, hfov: float | None
) -> "Camera | None":
    """The camera that the options describe: a function of the picture's size; None if none."""
    from footprints_edge.geometry.camera import Intrinsics

    if hfov is not None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise typer.BadParameter("give --hfov, or --fx and --fy, not both")
        Intrinsics.from_hfov(hfov, (1, 1))  # says at once what is wrong with it
        return lambda size: Intrinsics.from_hfov(hfov, size)
    if fx is None or fy is None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise typer.BadParameter("--fx and --fy belong together; --cx and --cy need both")
        return None
    Intrinsics(fx, fy, cx or 0.0, cy or 0.0)

    def from_size(size: tuple[int, int]) -> Intrinsics:
        height, width = size
        centre_x = (width - 1) / 2 if cx is None else cx
        centre_y = (height - 1) / 2 if cy is None else cy
        return Intrinsics(fx, fy, centre_x, centre_y)

    return from_size


def _videos_among(named: list[str], raw: str | None) -> list[str]:
    """Those arguments that name videos, streams and cameras, or the pipe of raw frames."""
    from footprints_edge.video.sources import is_video

    if raw is None:
        return [name for name in named if is_video(name)]
    if named != ["-"]:
        raise typer.BadParameter("--raw says what standard input holds; give - and nothing else")
    return named


def _overlay_with_panel(prediction: "GroundMaps") -> bytes:
    from footprints_edge.drawing.overlay import encode_overlay

    return encode_overlay(prediction, top_down=True)


def _path_encoder(ends: tuple[str, str], margin_m: float) -> "Encoder":
    """What draws the path between two points given as `X,Y`."""
    from footprints_edge.drawing.path import encode_path_picture
    from footprints_edge.navigation.path_planning import require_graph_search

    require_graph_search()
    start, goal = (_point(text) for text in ends)
    return partial(encode_path_picture, start=start, goal=goal, margin_m=margin_m)


def _point(text: str) -> tuple[float, float]:
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is no pixel; give --path X0,Y0 X1,Y1") from None
    return x, y


def _work(
    batch: "Batch",
    model: "Model",
    camera: "Camera | None",
    threshold: float,
    *,
    quiet: bool,
    verbose: bool,
) -> None:
    """Does the tasks; a picture that fails is noted, the others still come out."""
    from footprints_edge.cli.progress import Progress

    progress = Progress(len(batch.tasks), quiet=quiet)
    for done, task in enumerate(batch.tasks):
        progress.show(done, task.source.label)
        try:
            prediction = _predict_and_write(task, model, camera, threshold)
        except FootprintsError as error:
            batch.failures.append(str(error))
            continue
        except Exception as error:  # whatever it is, the other pictures still come out
            reason = f"{type(error).__name__}: {error}"
            batch.failures.append(f"{task.source.label} cannot be processed: {reason}")
            continue
        progress.clear()
        if verbose:
            complain(_line_about(task, prediction))
        for path in task.targets:
            typer.echo(path)
    progress.clear()


def _predict_and_write(
    task: "Task", model: "Model", camera: "Camera | None", threshold: float
) -> "Prediction":
    from footprints_edge.outputs.writers import write

    image = task.source.path or _standard_input()
    prediction = model.predict(image, intrinsics=camera, threshold=threshold)
    write(prediction, task.targets)
    return prediction


def _standard_input() -> bytes:
    data = sys.stdin.buffer.read() if sys.stdin else b""
    if not data:
        raise ImageError("standard input is empty; pipe a picture into it")
    return data


def _line_about(task: "Task", prediction: "Prediction") -> str:
    height, width = prediction.image_size
    camera = prediction.intrinsics
    timings = ", ".join(f"{stage} {ms:.1f}" for stage, ms in prediction.timings_ms.items())
    return (
        f"{task.source.label}: {width} x {height} px, "
        f"visible ground {prediction.visible_ground.mean():.0%}, "
        f"hidden {prediction.hidden_ground.mean():.0%}, "
        f"field of view {camera.hfov_deg(prediction.map_size):.0f} degrees ({camera.source}), "
        f"ms: {timings}"
    )


def _close(batch: "Batch", *, quiet: bool) -> None:
    """Says what was kept and what failed, and sets the exit code."""
    if batch.kept and not quiet:
        complain(
            f"Kept {len(batch.kept)} result(s) that were there already, such as {batch.kept[0]}; "
            "--overwrite replaces them."
        )
    if batch.failures:
        complain(f"{len(batch.failures)} of {batch.total} failed:")
        for failure in batch.failures:
            complain(f"  {failure}")
        raise typer.Exit(SOME_FAILED)


if __name__ == "__main__":
    main()
