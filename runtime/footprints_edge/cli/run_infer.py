"""What `fp-infer` does, once its options are known: runs the model on pictures, videos and bags.

Without typer: to import it takes a tenth of the time of a run on one picture.
"""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footprints_edge.cli.exit_codes import (
    MODEL_PROBLEM,
    SOME_FAILED,
    OptionError,
    complain,
    explained,
)
from footprints_edge.foundation.install_hint import install_hint

if TYPE_CHECKING:
    from collections.abc import Mapping

    from footprints_edge.cli.batch import Batch
    from footprints_edge.maps.ground_maps import GroundMaps
    from footprints_edge.model import Camera
    from footprints_edge.outputs.writers import Encoder
    from footprints_edge.ros.ground_messages import GroundOutput

RAY = "ray"
"""Name among the engines: the pictures go to a Ray cluster, whose workers run onnxruntime."""


def run_infer(
    images: list[str],
    *,
    output: Path | None = None,
    formats: list[str] | None = None,
    model: str | None = None,
    engine: str = "onnxruntime",
    providers: list[str] | None = None,
    threads: int | None = None,
    threshold: float = 0.5,
    flatten: bool = True,
    fx: float | None = None,
    fy: float | None = None,
    cx: float | None = None,
    cy: float | None = None,
    hfov: float | None = None,
    camera_file: Path | None = None,
    camera_height: float | None = None,
    pitch: float | None = None,
    roll: float | None = None,
    robot_height: float = 1.2,
    path: tuple[str, str] | None = None,
    margin: float = 0.0,
    every: int = 1,
    max_fps: float | None = None,
    raw: str | None = None,
    smooth: bool = False,
    bev: bool = False,
    topic: str | None = None,
    ground_frame: str = "camera_footprint",
    hidden: str = "cost",
    recursive: bool = False,
    overwrite: bool = False,
    quiet: bool = False,
    verbose: bool = False,
) -> None:
    """Finds the ground in pictures, videos and bags; the arguments are the options of `infer`.

    Raises:
        OptionError: If options do not go together.
        SystemExit: With the exit code, unless all is done.
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
            raise OptionError("--path works on pictures only, not on videos")
        if margin and not path:
            raise OptionError("--margin is for --path")
        if bev and not bags and "overlay" not in wanted:
            raise OptionError("--bev adds a view beside the overlay; add overlay to --format")
        if not (videos or bags) and (smooth or every != 1 or max_fps is not None):
            raise OptionError("--every, --max-fps and --smooth are for videos")
        if engine == RAY:
            _check_ray(images, others=[*videos, *bags], providers=providers)
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
            _infer_pictures(
                batch, model, engine, providers, threads, how, quiet=quiet, verbose=verbose
            )
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
            raise OptionError("give --camera, or --fx, --fy and --hfov, not both")
        return Calibration.read(calibration)
    from footprints_edge.geometry.camera import Intrinsics

    if hfov is not None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise OptionError("give --hfov, or --fx and --fy, not both")
        Intrinsics.from_hfov(hfov, (1, 1))  # report a wrong angle at once
        return lambda size: Intrinsics.from_hfov(hfov, size)
    if fx is None or fy is None:
        if (fx, fy, cx, cy) != (None, None, None, None):
            raise OptionError("give --fx and --fy together; --cx and --cy need both")
        return None
    Intrinsics(fx, fy, cx or 0.0, cy or 0.0)

    def from_size(size: tuple[int, int]) -> Intrinsics:
        height, width = size
        centre_x = (width - 1) / 2 if cx is None else cx
        centre_y = (height - 1) / 2 if cy is None else cy
        return Intrinsics(fx, fy, centre_x, centre_y)

    return from_size


def _infer_pictures(
    batch: "Batch",
    model: str | None,
    engine: str,
    providers: list[str] | None,
    threads: int | None,
    how: "Mapping[str, Any]",
    *,
    quiet: bool,
    verbose: bool,
) -> None:
    from footprints_edge.foundation.cores import usable_cores

    cores = threads or usable_cores()
    if engine == RAY:
        from footprints_edge.cli.infer_on_ray import infer_on_ray

        infer_on_ray(batch, model, how, workers=cores, quiet=quiet, verbose=verbose)
        return
    from footprints_edge.cli.infer_images import infer_images
    from footprints_edge.model import load

    at_once = min(cores, len(batch.tasks))
    at_once = 1 if engine == "openvino" else at_once  # it runs one picture at a time
    one_each = 1 if at_once > 1 else threads
    loaded = load(model, threads=one_each, providers=providers or None, engine=engine)
    predict = partial(loaded.predict, **how)
    infer_images(batch, predict, at_once=at_once, quiet=quiet, verbose=verbose)


def _check_ray(named: list[str], *, others: list[str], providers: list[str] | None) -> None:
    from footprints_edge.video.sources import STDIN

    if others or STDIN in named:
        raise OptionError("--engine ray is for picture files and folders of them")
    if providers:
        raise OptionError("--engine ray runs on processors; leave --provider out")
    from footprints_edge.parallel.on_ray import require_ray

    try:
        require_ray()
    except ModuleNotFoundError as error:
        raise OptionError(f"--engine ray needs the package ray: {install_hint('ray')}") from error


def _check_robot_height(robot_height_m: float) -> None:
    from footprints_edge.geometry.obstacle_heights import check_robot_height

    try:
        check_robot_height(robot_height_m)
    except ValueError as error:
        raise OptionError(f"--robot-height {robot_height_m:g}: {error}") from error


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
    from footprints_edge.video.sources import STDIN, is_video

    if raw is None:
        return [name for name in named if is_video(name)]
    if named != [STDIN]:
        raise OptionError("--raw describes standard input; give - and nothing else")
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
        raise OptionError(f"-o {output} names a bag, which is for one bag; give a folder")
    if not bags:
        if topic is not None:
            raise OptionError("--topic is for bags of ROS")
        return None
    from footprints_edge.ros.ground_messages import HIDDEN_COSTS, GroundOutput

    everything = GroundOutput()
    kinds = [part.strip() for text in formats or everything.kinds for part in text.split(",")]
    if unknown := [kind for kind in kinds if kind not in everything.kinds]:
        raise OptionError(
            f"bags do not support the format {', '.join(unknown)}; choose from "
            f"{', '.join(everything.kinds)}"
        )
    if hidden not in HIDDEN_COSTS:
        raise OptionError(f"--hidden {hidden}: give {', '.join(HIDDEN_COSTS)}")
    if not ground_frame:
        raise OptionError("--ground-frame is empty; give a name")
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
        raise OptionError(f"{text!r} is not a pixel; give --path X0,Y0 X1,Y1") from None
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
        raise SystemExit(MODEL_PROBLEM if always else SOME_FAILED)
