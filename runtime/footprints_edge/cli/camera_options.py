"""What the options of `fp-infer` say about the camera."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from footprints_edge.geometry.camera import ASSUMED_FOV_DEG
from footprints_edge.geometry.camera_pose import CameraPose

if TYPE_CHECKING:
    from footprints_edge.model import Camera


@dataclass(frozen=True)
class CameraOptions:
    """The camera, for every picture of a run.

    Attributes:
        intrinsics: Its intrinsics; None means EXIF, or an assumed lens.
        pose: What is known of its height, pitch and roll.
    """

    intrinsics: "Camera | None" = None
    pose: CameraPose = field(default_factory=CameraPose)

    def of_predict(self) -> dict[str, Any]:
        """The arguments of `Model.predict`."""
        return {
            "intrinsics": self.intrinsics,
            "camera_height_m": self.pose.height_m,
            "pitch_deg": self.pose.pitch_deg,
            "roll_deg": self.pose.roll_deg,
        }


def lens_warning(source: str) -> str:
    """What the terminal says once about a lens that was assumed; empty if it is known."""
    if source != "assumed":
        return ""
    return (
        f"Assumed a lens of {ASSUMED_FOV_DEG:g} degrees, as nothing is known of it: all metres "
        "depend on it; --hfov, --fx and --fy, or --camera give the right one."
    )
