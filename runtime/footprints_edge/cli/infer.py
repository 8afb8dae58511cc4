"""The command `fp-infer`: parses options and runs the model on pictures and videos."""

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import (
    HELP,
    MODEL_PROBLEM,
    SOME_FAILED,
    VersionOption,
    complain,
    explained,
)
from footprints_edge.cli.plain_arguments import read_plain

if TYPE_CHECKING:
    from footprints_edge.cli.batch import Batch
    from footprints_edge.maps.ground_maps import GroundMaps
    from footprints_edge.model import Camera
    from footprints_edge.outputs.writers import Encoder
    from footprints_edge.ros.ground_messages import GroundOutput

app = typer.Typer(context_settings=HELP, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def infer(
    images: Annotated[
        list[str],
        typer.Argument(
            help="Pictures, folders, or - for standard input; videos, rtsp://…, camera:0; bags "
            "of ROS."
        ),
    ],
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder for the results, or for one bag the bag to write (.mcap, .bag). Default: "
            "beside each picture.",
        ),
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            help="Output formats, separated by commas: overlay (default), npz, png16, json, ply, "
            "topdown, topdown_npz, topdown_ply, topdown_picture. For videos: overlay, json. For "
            "bags: grid, scan, points, overlay; default: all.",
        ),
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="Model file, or a name from fp-models list.")
    ] = None,
    engine: Annotated[
        str, typer.Option(help="onnxruntime, openvino, or a plug-in: onnxruntime-ep-….")
    ] = "onnxruntime",
    providers: Annotated[
        list[str] | None,
        typer.Option(
            "--provider",
            help="Execution provider of onnxruntime, such as CUDAExecutionProvider; several in "
            "order of preference. Default: the CPU.",
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Number of threads. Default: one per usable core."),
    ] = None,
    threshold: Annotated[
        float, typer.Option(min=0, max=1, help="Probability above which a pixel counts as ground.")
    ] = 0.5,
    flatten: Annotated[
        bool,
        typer.Option(
            " /--no-flatten", help="Keep the network's depth of flat ground, off its plane."
        ),
    ] = True,
    fx: Annotated[float | None, typer.Option(help="Focal length along x, in pixels.")] = None,
    fy: Annotated[float | None, typer.Option(help="Focal length along y, in pixels.")] = None,
    cx: Annotated[
        float | None, typer.Option(help="Principal point along x. Default: the centre.")
    ] = None,
    cy: Annotated[
        float | None, typer.Option(help="Principal point along y. Default: the centre.")
    ] = None,
    hfov: Annotated[
        float | None,
        typer.Option(help="Horizontal field of view in degrees, instead of --fx and --fy."),
    ] = None,
    camera_file: Annotated[
        Path | None,
        typer.Option(
            "--camera",
            metavar="FILE",
            help="Calibration file (YAML of ROS camera_calibration or OpenCV), with distortion: "
            "pictures are rectified first. Instead of --fx, --fy and --hfov.",
        ),
    ] = None,
    camera_height: Annotated[
        float | None,
        typer.Option(help="Height of the camera above the ground in metres, if known."),
    ] = None,
    pitch: Annotated[
        float | None, typer.Option(help="Downward pitch of the camera in degrees, if known.")
    ] = None,
    roll: Annotated[
        float | None,
        typer.Option(help="Roll of the camera in degrees, right side down, if known."),
    ] = None,
    robot_height: Annotated[
        float,
        typer.Option(
            help="Height of the robot in metres: what stands between a step (0.15 m) and this is "
            "an obstacle.",
        ),
    ] = 1.2,
    path: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="X0,Y0 X1,Y1",
            help="Plan a path between two pixels of the picture and draw it to .path.png.",
        ),
    ] = None,
    margin: Annotated[
        float, typer.Option(min=0, help="Distance in metres that the path keeps from obstacles.")
    ] = 0.0,
    every: Annotated[int, typer.Option(min=1, help="Process every Nth frame of a video.")] = 1,
    max_fps: Annotated[
        float | None, typer.Option(help="Process at most this many frames per second of a video.")
    ] = None,
    raw: Annotated[
        str | None,
        typer.Option(
            metavar="WxH[@FPS]",
            help="Read raw RGB frames of this size (width first) from standard input: "
            "ffmpeg … | fp-infer - --raw …",
        ),
    ] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="Smooth the maps of a video over time.")
    ] = False,
    bev: Annotated[
        bool,
        typer.Option("--bev", "--panel", help="Add a bird's-eye view beside the overlay."),
    ] = False,
    topic: Annotated[
        str | None, typer.Option(help="Topic of a bag's pictures, if it has several.")
    ] = None,
    ground_frame: Annotated[
        str, typer.Option(help="Bags: name of the ground's frame, below the camera.")
    ] = "camera_footprint",
    hidden: Annotated[
        str,
        typer.Option(help="Bags: what hidden ground is in grids: cost, unknown or free."),
    ] = "cost",
    recursive: Annotated[
        bool, typer.Option("--recursive", help="Search sub-folders, too.")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace existing results.")
    ] = False,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="Print results and errors only.")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("-v", "--verbose", help="Print one line per image.")
    ] = False,
    _version: VersionOption = False,
) -> None:
    """Find the walkable ground in pictures and videos, seen and hidden, and its distance in metres.

    Prints the files written. Exit codes: 0 all done, 1 some inputs failed,
    2 usage error, 3 model problem.
    """
    with explained():
        from footprints_edge.cli.batch import plan
        from footprints_edge.cli.camera_options import CameraOptions
        from footprints_edge.geometry.camera_pose import CameraPose
        from footprints_edge.model_files.registry import resolve

        camera = CameraOptions(
            _camera(fx, fy, cx, cy, hfov, camera_file), CameraPose(camera_height, pitch, roll)
        )
        _check_robot_height(robot_height)
        wanted = [part.strip() for text in formats or ["overlay"] for part in text.split(",")]
        extra = {".path.png": _path_encoder(path, margin)} if path else {}
        if bev and "overlay" in wanted:
            extra[".overlay.png"] = _overlay_with_bev
        images, pictures, videos, bags = _by_kind(images, raw, recursive=recursive)
        if (videos or bags) and path:
            raise typer.BadParameter("--path works on pictures only, not on videos")
        if not (videos or bags) and (smooth or every != 1 or max_fps is not None):
            raise typer.BadParameter("--every, --max-fps and --smooth are for videos")
        content = _bag_content(bags, images, formats, topic, ground_frame, hidden, output)
        if videos:
            from footprints_edge.video.capture import Pace, RawFormat

            pace = Pace(every, max_fps)
            layout = RawFormat.parse(raw) if raw else None
        batch = plan(
            pictures,
            wanted if pictures or not bags else ["overlay"],
            output,
            recursive=recursive,
            overwrite=overwrite,
            extra=extra,
        )
        how = {
            "threshold": threshold,
            "flatten": flatten,
            "robot_height_m": robot_height,
            **camera.of_predict(),
        }
        resolve(model)  # report a wrong name even if there is nothing to do
        if batch.tasks:
            from footprints_edge.cli.infer_images import infer_images
            from footprints_edge.foundation.cores import usable_cores
            from footprints_edge.model import load

            at_once = min(threads or usable_cores(), len(batch.tasks))
            at_once = 1 if engine == "openvino" else at_once  # it runs one picture at a time
            one_each = 1 if at_once > 1 else threads
            loaded = load(model, threads=one_each, providers=providers or None, engine=engine)
            predict = partial(loaded.predict, **how)
            infer_images(batch, predict, at_once=at_once, quiet=quiet, verbose=verbose)
            del loaded, predict
        if videos:
            from footprints_edge.cli.infer_video import VideoOptions, infer_videos
            from footprints_edge.foundation.cores import usable_cores
            from footprints_edge.model import load

            options = VideoOptions(
                pace,
                layout,
                smooth,
                bev,
                wanted,
                threads or usable_cores(),
                output,
                overwrite=overwrite,
                quiet=quiet,
                lens_assumed=camera.intrinsics is None,
            )
            loaded = load(model, threads=1, providers=providers or None, engine=engine)
            predict = partial(loaded.predict, **how)
            infer_videos(videos, options, predict, batch)
        if content is not None:
            from footprints_edge.cli.infer_bag import BagOptions, infer_bags

            bag_options = BagOptions(
                every, max_fps, topic, camera, content, bev, smooth, threads, output,
                overwrite=overwrite, quiet=quiet,
            )  # fmt: skip
            infer_bags(bags, bag_options, (model, providers or None, engine), how, batch)
        _close(batch, quiet=quiet)


def main() -> None:
    """Runs `fp-infer`; see `start`."""
    plain = read_plain(sys.argv[1:])
    if plain is None:
        app()
        return
    try:
        infer(**plain)
    except typer.Exit as ended:
        sys.exit(ended.exit_code)
    except typer.BadParameter:  # found before anything was done; typer explains it
        app()


def _camera(
    fx: float | None,
    fy: float | None,
    cx: float | None,
    cy: float | None,
    hfov: float | None,
    calibration: Path | None,
) -> "Camera | None":
    """The camera of the options, as a function of the picture's size; None if not given."""
    if calibration is not None:
        from footprints_edge.inputs.calibration import Calibration

        if (fx, fy, cx, cy, hfov) != (None, None, None, None, None):
            raise typer.BadParameter("give --camera, or --fx, --fy and --hfov, not both")
        return Calibration.read(calibration)
    from footprints_edge.geometry.camera import Intrinsics

    if hfov is not None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise typer.BadParameter("give --hfov, or --fx and --fy, not both")
        Intrinsics.from_hfov(hfov, (1, 1))  # report a wrong angle at once
        return lambda size: Intrinsics.from_hfov(hfov, size)
    if fx is None or fy is None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise typer.BadParameter("give --fx and --fy together; --cx and --cy need both")
        return None
    Intrinsics(fx, fy, cx or 0.0, cy or 0.0)

    def from_size(size: tuple[int, int]) -> Intrinsics:
        height, width = size
        centre_x = (width - 1) / 2 if cx is None else cx
        centre_y = (height - 1) / 2 if cy is None else cy
        return Intrinsics(fx, fy, centre_x, centre_y)

    return from_size


def _check_robot_height(robot_height_m: float) -> None:
    from footprints_edge.geometry.obstacle_heights import check_robot_height

    try:
        check_robot_height(robot_height_m)
    except ValueError as error:
        raise typer.BadParameter(f"--robot-height {robot_height_m:g}: {error}") from error


def _by_kind(
    named: list[str], raw: str | None, *, recursive: bool
) -> tuple[list[str], list[str], list[str], list[str]]:
    """The arguments, folders of videos opened, and of these the pictures, videos and bags."""
    from footprints_edge.cli.sources import folder_of_videos
    from footprints_edge.ros.bag_names import is_bag

    named = [part for name in named for part in folder_of_videos(name, recursive=recursive)]
    videos = _videos_among(named, raw)
    bags = [] if raw else [name for name in named if is_bag(name)]
    return named, [name for name in named if name not in {*videos, *bags}], videos, bags


def _videos_among(named: list[str], raw: str | None) -> list[str]:
    """The arguments that name videos, streams, cameras, or a pipe of raw frames."""
    from footprints_edge.video.sources import is_video

    if raw is None:
        return [name for name in named if is_video(name)]
    if named != ["-"]:
        raise typer.BadParameter("--raw describes standard input; give - and nothing else")
    return named


def _bag_content(
    bags: list[str],
    all_inputs: list[str],
    formats: list[str] | None,
    topic: str | None,
    ground_frame: str,
    hidden: str,
    output: Path | None,
) -> "GroundOutput | None":
    """What is written of bags; None without bags."""
    from footprints_edge.ros.bag_names import names_file

    if names_file(output) and not (bags and len(all_inputs) == 1):
        raise typer.BadParameter(f"-o {output} names a bag, which is for one bag; give a folder")
    if not bags:
        if topic is not None:
            raise typer.BadParameter("--topic is for bags of ROS")
        return None
    from footprints_edge.ros.ground_messages import HIDDEN_COSTS, GroundOutput

    everything = GroundOutput()
    kinds = [part.strip() for text in formats or everything.kinds for part in text.split(",")]
    if unknown := [kind for kind in kinds if kind not in everything.kinds]:
        raise typer.BadParameter(
            f"bags do not support the format {', '.join(unknown)}; choose from "
            f"{', '.join(everything.kinds)}"
        )
    if hidden not in HIDDEN_COSTS:
        raise typer.BadParameter(f"--hidden {hidden}: give {', '.join(HIDDEN_COSTS)}")
    if not ground_frame:
        raise typer.BadParameter("--ground-frame is empty; give a name")
    return GroundOutput(tuple(kinds), ground_frame, hidden)


def _overlay_with_bev(prediction: "GroundMaps") -> bytes:
    from footprints_edge.drawing.overlay import encode_overlay

    return encode_overlay(prediction, bev=True)


def _path_encoder(ends: tuple[str, str], margin_m: float) -> "Encoder":
    """An encoder that draws the path between two points given as `X,Y`."""
    from footprints_edge.drawing.path import encode_path_picture
    from footprints_edge.navigation.path_planning import require_graph_search

    require_graph_search()
    start, goal = (_point(text) for text in ends)
    return partial(encode_path_picture, start=start, goal=goal, margin_m=margin_m)


def _point(text: str) -> tuple[float, float]:
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a pixel; give --path X0,Y0 X1,Y1") from None
    return x, y


def _close(batch: "Batch", *, quiet: bool) -> None:
    """Reports notes, kept and failed results, and sets the exit code.

    Beside results that are written anew nothing is left of a killed run; here beside those kept.
    """
    if batch.kept:
        from footprints_edge.foundation.parts import remove_abandoned

        for folder in {path.parent for path in batch.kept}:
            remove_abandoned(folder)
    for note in () if quiet else batch.notes:
        complain(f"Note: {note}")
    if batch.kept and not quiet:
        complain(
            f"Kept {len(batch.kept)} existing result(s), such as {batch.kept[0]}; "
            "--overwrite replaces them."
        )
    if batch.failures:
        complain(f"{len(batch.failures)} of {batch.total} failed:")
        for failure in batch.failures:
            complain(f"  {failure}")
        always = batch.model_failures == len(batch.tasks) > 0  # it is not the pictures
        raise typer.Exit(MODEL_PROBLEM if always else SOME_FAILED)


if __name__ == "__main__":
    from footprints_edge.cli.start import start

    start("footprints_edge.cli.infer")
