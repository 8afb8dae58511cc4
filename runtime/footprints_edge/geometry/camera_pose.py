"""What is known of the camera's pose above the ground: its height, pitch and roll.

Pitch and roll are those of `GroundPlane`: pitch is downward, roll has the right side down.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import CameraPoseError


@dataclass(frozen=True)
class CameraPose:
    """The known part of a camera's pose above level ground; None where it is not known.

    Attributes:
        height_m: Height of the camera above the ground, metres.
        pitch_deg: Downward pitch in degrees: 0 looks at the horizon, 90 straight down.
        roll_deg: Roll about the optical axis in degrees, right side down.
    """

    height_m: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None

    def __post_init__(self) -> None:
        """Rejects impossible values.

        Raises:
            CameraPoseError: If the height is not positive, the pitch is beyond 90 degrees, or the
                roll beyond 180.
        """
        for field in ("height_m", "pitch_deg", "roll_deg"):
            if (value := getattr(self, field)) is not None:
                # a number of numpy becomes one of Python
                object.__setattr__(self, field, _number(field, value))
        if self.height_m is not None and not (math.isfinite(self.height_m) and self.height_m > 0):
            raise CameraPoseError(
                f"the camera height is {self.height_m}; give it as a positive number of metres "
                "above the ground"
            )
        for name, value, most in (("pitch", self.pitch_deg, 90), ("roll", self.roll_deg, 180)):
            if value is not None and not abs(value) <= most:
                raise CameraPoseError(
                    f"the {name} is {value}; give degrees from -{most} to {most} (pitch down and "
                    "right side down are positive)"
                )

    @classmethod
    def from_gravity(cls, gravity: Sequence[float], height_m: float | None = None) -> "CameraPose":
        """The pose of a camera that knows which way is down.

        Args:
            gravity: The direction of gravity in camera axes (x right, y down, z forward), of any
                length. An accelerometer at rest measures the opposite direction.
            height_m: Height of the camera above the ground, metres, if known.

        Raises:
            CameraPoseError: If it is not three finite numbers, or all are 0.
        """
        try:
            down = np.asarray(gravity, np.float64)
        except (TypeError, ValueError):
            down = np.empty(0)
        length = float(np.linalg.norm(down)) if down.shape == (3,) else math.nan
        if not (math.isfinite(length) and length > 0):
            raise CameraPoseError(
                f"gravity is {gravity!r}; give its direction in camera axes as three numbers: x "
                "right, y down, z forward"
            )
        x, y, z = (float(part) for part in down / length)
        return cls(
            height_m,
            math.degrees(math.asin(max(-1.0, min(1.0, z)))),
            math.degrees(math.atan2(x, y)),
        )

    @property
    def anything(self) -> bool:
        """Whether anything is known."""
        return not (self.height_m is None and self.pitch_deg is None and self.roll_deg is None)

    @property
    def everything(self) -> bool:
        """Whether all of it is known: then the ground plane is, too."""
        return None not in (self.height_m, self.pitch_deg, self.roll_deg)


def _number(name: str, value: float) -> float:
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise CameraPoseError(f"{name} is {value!r}; give it as a number") from error


def up_vector(pitch_deg: float, roll_deg: float) -> NDArray[np.float64]:
    """The unit vector that points up, in camera axes, float64 (3,)."""
    pitch, roll = math.radians(pitch_deg), math.radians(roll_deg)
    level = math.cos(pitch)
    return np.array([-math.sin(roll) * level, -math.cos(roll) * level, -math.sin(pitch)])
