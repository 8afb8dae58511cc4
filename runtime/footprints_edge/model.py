"""Load a model and predict with it: the stages, in order."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias

from footprints_edge.engines.engine import Engine
from footprints_edge.engines.open_engine import open_engine
from footprints_edge.errors import CameraPoseError, IntrinsicsError, ModelError
from footprints_edge.foundation.types import Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.obstacle_heights import ROBOT_HEIGHT_M, check_robot_height
from footprints_edge.inputs.calibration import Calibration
from footprints_edge.inputs.images import DecodedImage, ImageSource, decode
from footprints_edge.inputs.preprocessing import (
    FILTERS,
    STRIDE,
    enough_for,
    preprocess,
    working_size,
)
from footprints_edge.maps.decode import decode_maps
from footprints_edge.maps.ground_maps import ModelInfo
from footprints_edge.model_files import registry
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge.prediction import FlattenedWhenRead, Prediction

if TYPE_CHECKING:
    from footprints_edge.parallel.in_order import PredictionIterator
    from footprints_edge.video.stream import StreamedFrame

Camera: TypeAlias = Intrinsics | Calibration | Callable[[Size], Intrinsics]
"""A camera in pixels of the upright picture, a calibrated lens, or a function from the picture's
(H, W) to a camera."""


class Model:
    """A loaded model. It keeps no state between calls, so many threads may share it."""

    def __init__(self, engine: Engine, reload: "Callable[[], Model] | None" = None) -> None:
        """Reads the metadata of a loaded file.

        Args:
            engine: The engine with the file.
            reload: Loads the same file again, in another process, say; it can be pickled.

        Raises:
            ModelError: If the metadata is missing, or names an unknown filter or a bad input size.
        """
        self.engine = engine
        self._reload = reload
        self.metadata = ModelMetadata.from_props(engine.props, engine.path)
        if self.metadata.resize not in FILTERS:
            raise ModelError(
                f"{engine.path} needs its input resized with {self.metadata.resize!r}; "
                f"this version supports {', '.join(FILTERS)}; upgrade footprints-edge"
            )
        if engine.input_size and any(side % STRIDE for side in engine.input_size):
            raise ModelError(
                f"{engine.path} has the fixed input size {engine.input_size}; both sides must be "
                f"multiples of {STRIDE}; convert it again"
            )

    def __repr__(self) -> str:
        return f"<Model {self.name}, {self.metadata.precision}, {self.path}>"

    def __reduce__(self) -> "tuple[Callable[[], Model], tuple[()]]":
        """Pickles the path, not the weights: whoever unpickles it loads the same file again."""
        if self._reload is None:
            raise TypeError("this model was not made by load(), so it cannot be loaded again")
        return self._reload, ()

    @property
    def path(self) -> Path:
        """The model file."""
        return self.engine.path

    @property
    def sha256(self) -> str:
        """SHA-256 of the model file."""
        return self.engine.sha256

    @property
    def name(self) -> str:
        """The model's name, from its metadata."""
        return self.metadata.name

    def input_size(self, image_size: Size) -> Size:
        """The network's input size (h, w) for a picture of `image_size` (H, W)."""
        return self.engine.input_size or working_size(image_size)

    def decode(self, image: ImageSource) -> DecodedImage:
        """Decodes a picture at the resolution that this model needs; see `images.decode`.

        Raises:
            ImageError: If the image cannot be read.
        """
        return decode(image, lambda size: enough_for(self.input_size(size)))

    def predict(
        self,
        image: ImageSource,
        *,
        intrinsics: Camera | None = None,
        threshold: float = 0.5,
        flatten: bool = True,
        camera_height_m: float | None = None,
        pitch_deg: float | None = None,
        roll_deg: float | None = None,
        gravity: Sequence[float] | None = None,
        robot_height_m: float = ROBOT_HEIGHT_M,
    ) -> Prediction:
        """Finds the ground in one picture.

        Args:
            image: Path, encoded bytes, binary file object, PIL image, or uint8 array (H, W, 3)
                in RGB order.
            intrinsics: The camera of the full upright picture, in its pixels, or a function that
                makes it from the picture's (H, W), such as
                `lambda size: Intrinsics.from_hfov(65, size)`. A `Calibration` rectifies the
                picture first; the results are then for the rectified camera. None reads EXIF, or
                else assumes a field of view; `Prediction.intrinsics.source` says which.
            threshold: Probability above which a pixel counts as ground.
            flatten: Snap the ground's depth to the ground plane where the ground is flat, as
                `Prediction.flattened` does; False keeps the network's depth.
            camera_height_m: Height of the camera above the ground, metres, if known. What is known
                of the pose holds, and the rest is fitted. With height, pitch and roll the ground
                plane is exact, and only the masks are the network's.
            pitch_deg: Downward pitch of the camera, degrees, if known.
            roll_deg: Roll about the optical axis, degrees, right side down, if known.
            gravity: Direction of gravity in camera axes (x right, y down, z forward), instead of
                pitch and roll.
            robot_height_m: Height of the robot, metres, for grids, scans, paths and pictures: what
                stands between a step and this height is an obstacle.

        Returns:
            Maps at the network's input size; see `Prediction.at_image_size`.

        Raises:
            ImageError: If the image cannot be read.
            IntrinsicsError: If the intrinsics are impossible.
            CameraPoseError: If the pose is impossible, or gravity is given beside pitch or roll.
            ModelError: If the network fails to run.
            ValueError: If the threshold is not between 0 and 1, or the robot is not higher than a
                step.
        """
        threshold = float(threshold)
        if not 0 <= threshold <= 1:
            raise ValueError(f"threshold is {threshold}; it is a probability: give 0 to 1")
        if not (
            intrinsics is None
            or isinstance(intrinsics, Intrinsics | Calibration)
            or callable(intrinsics)
        ):
            raise IntrinsicsError(
                f"intrinsics is a {type(intrinsics).__name__}; pass fp.Intrinsics(fx, fy, cx, cy)"
            )
        check_robot_height(robot_height_m)
        pose = _pose_of(camera_height_m, pitch_deg, roll_deg, gravity)
        times = [perf_counter()]
        decoded = self.decode(image)
        if isinstance(intrinsics, Calibration):
            decoded, intrinsics = intrinsics.rectified(decoded)
        times.append(perf_counter())
        size = self.input_size(decoded.size)
        network_input = preprocess(decoded.pixels, size, self.metadata.resize, self.engine.threads)
        times.append(perf_counter())
        maps = self.engine.run(network_input)
        times.append(perf_counter())
        camera = _camera_of(decoded, intrinsics).scaled(decoded.size, size)
        timings_ms: dict[str, float] = {}
        prediction = Prediction(
            maps=decode_maps(maps, self.metadata, camera),
            picture=decoded,
            intrinsics=camera,
            threshold=threshold,
            model=ModelInfo(self.name, self.metadata.precision, self.sha256, self.engine.runtime),
            timings_ms=timings_ms,
            pose=pose,
            robot_height_m=robot_height_m,
        )
        if flatten:
            prediction = FlattenedWhenRead.of(prediction)
        times.append(perf_counter())
        stages = ("decode", "preprocess", "inference", "postprocess")
        timings_ms |= {
            stage: 1000 * (b - a) for stage, (a, b) in zip(stages, pairwise(times), strict=True)
        }
        return prediction

    __call__ = predict

    def predict_many(
        self,
        images: Iterable[ImageSource],
        *,
        workers: int | None = None,
        intrinsics: Camera | None = None,
        threshold: float = 0.5,
        flatten: bool = True,
        camera_height_m: float | None = None,
        pitch_deg: float | None = None,
        roll_deg: float | None = None,
        gravity: Sequence[float] | None = None,
        robot_height_m: float = ROBOT_HEIGHT_M,
    ) -> "PredictionIterator[Prediction]":
        """Finds the ground in many pictures, several at a time.

        Args:
            images: The pictures, each as for `predict`; taken one after the other as they are
                needed, so there may be any number.
            workers: Pictures at a time; None means 2, which decodes one while the network sees
                another. On many cores, `load(threads=1)` and as many workers as cores is fastest.
            intrinsics: As for `predict`.
            threshold: As for `predict`.
            flatten: As for `predict`.
            camera_height_m: As for `predict`.
            pitch_deg: As for `predict`.
            roll_deg: As for `predict`.
            gravity: As for `predict`.
            robot_height_m: As for `predict`.

        Returns:
            An iterator over the predictions in the order of the pictures. A picture that fails
            raises its error when its turn comes; the next call of `next` goes on after it.

        Raises:
            TypeError: If `images` is one picture.
            ValueError: If the number of workers is not positive.
        """
        from footprints_edge.parallel.in_order import PredictionIterator

        one_picture = isinstance(images, str | bytes | os.PathLike) or hasattr(images, "read")
        if one_picture or getattr(images, "ndim", None) == 3:
            raise TypeError("images is one picture; give a list of them, or use predict")

        predict = partial(
            self.predict,
            intrinsics=intrinsics,
            threshold=threshold,
            flatten=flatten,
            camera_height_m=camera_height_m,
            pitch_deg=pitch_deg,
            roll_deg=roll_deg,
            gravity=gravity,
            robot_height_m=robot_height_m,
        )
        return PredictionIterator(predict, images, 2 if workers is None else workers)

    def stream(
        self,
        source: str | os.PathLike[str] | BinaryIO,
        *,
        raw: str | None = None,
        every: int = 1,
        max_fps: float | None = None,
        smooth: bool = False,
        workers: int | None = None,
        intrinsics: Camera | None = None,
        threshold: float = 0.5,
        flatten: bool = True,
        camera_height_m: float | None = None,
        pitch_deg: float | None = None,
        roll_deg: float | None = None,
        gravity: Sequence[float] | None = None,
        robot_height_m: float = ROBOT_HEIGHT_M,
    ) -> "Iterator[StreamedFrame[Prediction]]":
        """Finds the ground in every frame of a video, camera, stream or pipe (extra `video`).

        Decoding, inference and your own code run at the same time. A camera or stream drops frames
        that come faster than they are taken; a file or pipe waits. Leaving the loop, or `close()`
        of the iterator, closes the source.

        Args:
            source: A video file, `camera:0`, `rtsp://…`, or with `raw` a pipe: a binary file
                object, which stays open but has lost what was read in advance, or `-` for standard
                input.
            raw: Layout of the raw RGB frames of a pipe, `WIDTHxHEIGHT[@FPS]`.
            every: Process every Nth frame.
            max_fps: Process at most this many frames per second of the video's time.
            smooth: Smooth the maps over time, as `Tracker` does.
            workers: Frames to predict at a time; None means 1. With `load(threads=1)`, as many as
                cores are fastest.
            intrinsics: As for `predict`.
            threshold: As for `predict`.
            flatten: As for `predict`.
            camera_height_m: As for `predict`.
            pitch_deg: As for `predict`.
            roll_deg: As for `predict`.
            gravity: As for `predict`.
            robot_height_m: As for `predict`.

        Yields:
            Frames in order, with `index`, `time_s` and `prediction`. Broken ones are left out.

        Raises:
            VideoError: If the source cannot be opened, ends in an error, or OpenCV is missing.
        """
        from footprints_edge.video.capture import Pace, open_source
        from footprints_edge.video.smoothing import Tracker
        from footprints_edge.video.stream import stream_video

        predict = partial(
            self.predict,
            intrinsics=intrinsics,
            threshold=threshold,
            flatten=flatten,
            camera_height_m=camera_height_m,
            pitch_deg=pitch_deg,
            roll_deg=roll_deg,
            gravity=gravity,
            robot_height_m=robot_height_m,
        )
        return stream_video(
            open_source(source, Pace(every, max_fps), raw),
            lambda frame: predict(frame.image),
            then=Tracker().update if smooth else None,
            at_once=1 if workers is None else workers,
        )


def load(
    model: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    providers: Sequence[str | tuple[str, Mapping[str, Any]]] | None = None,
    engine: str = "onnxruntime",
    session_options: Mapping[str, str] | None = None,
) -> Model:
    """Loads a model.

    Args:
        model: A registered name, the path of an ONNX file, or None for the bundled default.
        threads: Threads for one prediction; None means all cores that this process may use.
        providers: onnxruntime execution providers in order of preference; None means CPU. One with
            options is a pair, such as `("CUDAExecutionProvider", {"device_id": 1})`.
        engine: `onnxruntime`, `openvino` (the extra `openvino`), or a package that plugs an
            execution provider into onnxruntime, such as `onnxruntime-ep-openvino`. There is no
            fallback to another engine. `Prediction.model.runtime` says which one ran.
        session_options: Configuration entries of onnxruntime's session, such as
            `{"session.intra_op.allow_spinning": "0"}`; for `openvino`, properties of its CPU
            plugin.

    Raises:
        ModelError: If the model is unknown, damaged or not a footprints-edge file, or if a
            provider or engine is not available, or an engine refuses its options.
    """
    path = registry.resolve(None if model is None else os.fsdecode(model))
    opened = open_engine(
        path, engine, threads=threads, providers=providers, session_options=session_options
    )
    again = partial(
        _load_again,
        path.absolute(),
        opened.sha256,
        threads=threads,
        providers=providers,
        engine=engine,
        session_options=session_options,
    )
    return Model(opened, again)


def _load_again(path: Path, sha256: str, **options: Any) -> Model:  # noqa: ANN401 - those of load
    """Loads a file that must be the same still."""
    model = load(path, **options)
    if model.sha256 != sha256:
        raise ModelError(f"{path} is another file than when the model was pickled")
    return model


def _pose_of(
    height_m: float | None,
    pitch_deg: float | None,
    roll_deg: float | None,
    gravity: Sequence[float] | None,
) -> CameraPose:
    if gravity is None:
        return CameraPose(height_m, pitch_deg, roll_deg)
    if not (pitch_deg is None and roll_deg is None):
        raise CameraPoseError(
            f"pitch_deg is {pitch_deg}, roll_deg is {roll_deg} and gravity {gravity!r}; give "
            "either gravity, or pitch and roll"
        )
    return CameraPose.from_gravity(gravity, height_m)


def _camera_of(
    image: DecodedImage, given: Intrinsics | Callable[[Size], Intrinsics] | None
) -> Intrinsics:
    if isinstance(given, Intrinsics):
        return given
    if given is not None:
        camera = given(image.size)
        if not isinstance(camera, Intrinsics):
            raise IntrinsicsError(
                f"the function for intrinsics gave a {type(camera).__name__}; it must return "
                "fp.Intrinsics(fx, fy, cx, cy)"
            )
        return camera
    if image.focal_35mm is not None:
        return Intrinsics.from_focal_35mm(image.focal_35mm, image.size)
    return Intrinsics.assumed(image.size)
