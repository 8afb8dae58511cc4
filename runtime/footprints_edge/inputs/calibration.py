"""Calibration files of real lenses, and the rectification of their pictures.

Results hold for the rectified camera: a pinhole without distortion that sees the part of the
picture which no black border reaches.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Lock
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError, VideoError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import MAX_SIDE, DecodedImage

DistortionModel: TypeAlias = Literal["plumb_bob", "rational_polynomial", "equidistant"]

_FISHEYE = {"equidistant", "fisheye"}
_COEFFICIENTS = {
    "plumb_bob": (4, 5),
    "rational_polynomial": (8, 12, 14),
    "equidistant": (4,),
}
_MOST_PX = 64_000_000
"""Larger pictures are rectified at the reduced size that the network needs: the remap takes six
bytes for each pixel."""

_MOST_CHARACTERS = 400_000
"""Of a calibration file; those that list all points of a chessboard have tens of thousands."""

_SAME_SHAPE = 0.01
"""Relative difference of a picture's aspect ratio from the calibration's that is allowed."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibrated lens: the content of a calibration file.

    Pass it to `Model.predict` as `intrinsics`. It keeps the last remap, so use one object for all
    pictures of a camera.

    Attributes:
        size: (H, W) of the pictures of the calibration.
        matrix: float64 (3, 3), K.
        model: The distortion's model, by ROS's names; `equidistant` is a fisheye lens.
        distortion: float64 (N,), its coefficients, in OpenCV's order.
    """

    size: Size
    matrix: NDArray[np.float64]
    model: DistortionModel
    distortion: NDArray[np.float64]
    _maps: dict[Size, tuple[Any, Any, Intrinsics]] = field(default_factory=dict, repr=False)
    _lock: Any = field(default_factory=Lock, repr=False)

    @classmethod
    def read(cls, path: str | Path) -> "Calibration":
        """Reads the YAML that ROS's `camera_calibration` or OpenCV's `FileStorage` writes.

        Raises:
            IntrinsicsError: If it cannot be read, or lacks the camera's matrix, its size or its
                distortion.
            VideoError: If PyYAML is missing.
        """
        path = Path(path)
        try:
            with path.open(encoding="utf-8") as file:
                text = file.read(_MOST_CHARACTERS + 1)
        except (OSError, UnicodeDecodeError) as error:
            raise IntrinsicsError(f"{path}: cannot be read as a calibration: {error}") from error
        if len(text) > _MOST_CHARACTERS:
            raise IntrinsicsError(
                f"{path}: a calibration has at most {_MOST_CHARACTERS:,} characters"
            )
        try:
            return _parsed(text)
        except IntrinsicsError as error:
            raise IntrinsicsError(f"{path}: {error}") from None

    @classmethod
    def of(
        cls, size: Size, matrix: NDArray[np.float64], model: str, distortion: NDArray[np.float64]
    ) -> "Calibration":
        """The calibration that a file or a message states.

        Args:
            size: (H, W) of the pictures of the calibration.
            matrix: 9 numbers, K by rows.
            model: The distortion's model as ROS names it; empty if it is not stated.
            distortion: Its coefficients.

        Raises:
            IntrinsicsError: If the model is not supported, or the numbers cannot be.
        """
        coefficients = np.ravel(distortion)
        if model in _FISHEYE:
            known: DistortionModel = "equidistant"
        elif model in {"", "plumb_bob", "rational_polynomial"}:
            rational = model == "rational_polynomial" or coefficients.size > 5
            known = "rational_polynomial" if rational else "plumb_bob"
        else:
            raise IntrinsicsError(
                f"the distortion model is {model!r}; plumb_bob, rational_polynomial and "
                "equidistant are supported"
            )
        if coefficients.size not in _COEFFICIENTS[known] or not np.isfinite(coefficients).all():
            raise IntrinsicsError(
                f"{known} has {coefficients.size} coefficients; it needs "
                f"{' or '.join(map(str, _COEFFICIENTS[known]))} finite numbers"
            )
        K = np.reshape(matrix, (3, 3))
        Intrinsics(K[0, 0], K[1, 1], K[0, 2], K[1, 2])  # rejects impossible values
        return cls(size, K, known, coefficients)

    def rectified(self, image: DecodedImage) -> tuple[DecodedImage, Intrinsics]:
        """The picture as a pinhole camera would have taken it, and that camera.

        A picture of more than 64 million pixels comes out at a reduced size, with a note.

        Raises:
            IntrinsicsError: If the picture's shape is not that of the calibration.
        """
        height, width = image.size
        shape = width / height * self.size[0] / self.size[1]
        if abs(shape - 1) > _SAME_SHAPE:
            raise IntrinsicsError(
                f"the picture is {width} x {height} pixels, the calibration is for "
                f"{self.size[1]} x {self.size[0]}; give uncropped pictures of that camera, held as "
                "during the calibration"
            )
        given = image.rgb if height * width <= _MOST_PX else image.pixels
        size = given.shape[0], given.shape[1]
        across, down, camera = self._remap(size)
        cv2 = opencv()
        pixels: Rgb = cv2.remap(
            given, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        notes = image.notes
        if size != image.size:
            label = image.name or "the picture"
            notes += (f"{label}: very large, so rectified at {size[1]} x {size[0]} pixels",)
        return replace(image, pixels=pixels, file=None, notes=notes), camera

    def _remap(self, size: Size) -> tuple[Any, Any, Intrinsics]:
        with self._lock:
            if size not in self._maps:
                self._maps.clear()
                self._maps[size] = self._make_remap(size)
            return self._maps[size]

    def _make_remap(self, size: Size) -> tuple[Any, Any, Intrinsics]:
        cv2 = opencv()
        given = Intrinsics(
            self.matrix[0, 0], self.matrix[1, 1], self.matrix[0, 2], self.matrix[1, 2]
        )
        K, wh = given.scaled(self.size, size).matrix, size[::-1]
        if self.model == "equidistant":
            new = cv2.fisheye.estimateNewCameraMatrixForUndistortRectify(
                K, self.distortion, wh, np.eye(3), balance=0.0
            )
            across, down = cv2.fisheye.initUndistortRectifyMap(
                K, self.distortion, np.eye(3), new, wh, cv2.CV_16SC2
            )
        else:
            new, _ = cv2.getOptimalNewCameraMatrix(K, self.distortion, wh, 0.0, wh)
            across, down = cv2.initUndistortRectifyMap(
                K, self.distortion, None, new, wh, cv2.CV_16SC2
            )
        camera = Intrinsics(new[0, 0], new[1, 1], new[0, 2], new[1, 2], "rectified")
        return across, down, camera


def _parsed(text: str) -> Calibration:
    content = _yaml(text)
    matrix = _matrix(content, "camera_matrix", "Camera_Matrix", "cameraMatrix", "K")
    distortion = _matrix(
        content,
        "distortion_coefficients",
        "Distortion_Coefficients",
        "distCoeffs",
        "dist_coeffs",
        "D",
    )
    width = _number(content, "image_width", "image_Width", "width")
    height = _number(content, "image_height", "image_Height", "height")
    if matrix is None or matrix.size != 9 or distortion is None or not width or not height:
        raise IntrinsicsError(
            "a calibration needs image_width, image_height, camera_matrix (3 x 3) and "
            "distortion_coefficients, as ROS's camera_calibration or OpenCV write them"
        )
    if not all(0.5 < side <= MAX_SIDE for side in (width, height)):
        raise IntrinsicsError(
            f"the pictures of a calibration cannot be {width:g} x {height:g} pixels"
        )
    size = round(height), round(width)
    fisheye = _is_fisheye(content)
    stated = content.get("distortion_model", "")
    model = stated if isinstance(stated, str) else ""
    return Calibration.of(size, matrix, "equidistant" if fisheye else model, distortion)


def _yaml(text: str) -> dict[str, Any]:
    """The entries of a YAML file; all numbers are strings still.

    Not by OpenCV's own reader, which a spoiled file makes write where it must not.
    """
    try:
        import yaml
    except ModuleNotFoundError:
        raise VideoError(
            f"calibration files need the package PyYAML; {install_hint('video')}"
        ) from None
    head, _, rest = text.lstrip("\ufeff \t\r\n").partition("\n")
    if head.startswith("%YAML"):  # "%YAML:1.0" of OpenCV, which YAML does not know
        text = "\n" + rest
    try:
        if "*" in text and any(isinstance(each, yaml.AliasEvent) for each in yaml.parse(text)):
            # a few of them make lists without end
            raise IntrinsicsError("not a calibration in YAML (a value stands for another)")
        content = yaml.load(text, Loader=yaml.BaseLoader)  # no tags, no objects
    except yaml.MarkedYAMLError as error:  # its text would quote the file
        line = error.problem_mark.line + 1 if error.problem_mark else 1
        problem = f"line {line}: {error.problem!s:.200}"
        raise IntrinsicsError(f"not a calibration in YAML ({problem})") from None
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # characters that are none
        raise IntrinsicsError(f"not a calibration in YAML ({error!s:.200})") from None
    except RecursionError:
        raise IntrinsicsError("not a calibration in YAML (its values are too deep)") from None
    return content if isinstance(content, dict) else {}


def _is_fisheye(content: dict[str, Any]) -> bool:
    """Whether the file says so, as OpenCV's number or as YAML's word."""
    for name in ("fisheye_model", "fisheye"):
        if (stated := content.get(name)) is not None:
            word = str(stated).lower()
            return word in {"true", "yes", "on"} or (
                word not in {"false", "no", "off"} and bool(_number(content, name))
            )
    return False


def _matrix(content: dict[str, Any], *names: str) -> NDArray[np.float64] | None:
    """A matrix by one of its names: a map of rows, cols and data, or a list."""
    for name in names:
        if name in content:
            stated = content[name]
            numbers = stated.get("data") if isinstance(stated, dict) else stated
            try:
                return np.ravel(np.array(numbers, np.float64))
            except (ValueError, TypeError):
                raise IntrinsicsError(
                    f"{name} of the calibration is not a matrix of numbers"
                ) from None
    return None


def _number(content: dict[str, Any], *names: str) -> float | None:
    for name in names:
        if name in content:
            try:
                return float(content[name])
            except (ValueError, TypeError):
                raise IntrinsicsError(
                    f"{name} of the calibration is not a number but {str(content[name])[:40]!r}"
                ) from None
    return None
