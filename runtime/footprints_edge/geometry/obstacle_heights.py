"""Between which heights above the ground a thing stands in a robot's way."""

import math

STEP_HEIGHT_M = 0.15
"""Lower things are no obstacles: a network's depth does not tell them from the ground."""

ROBOT_HEIGHT_M = 1.2
"""Default height of the robot: higher things, such as lamps and table tops of bars, are passed
beneath."""


def check_robot_height(robot_height_m: float) -> None:
    """Checks the height of a robot.

    Raises:
        ValueError: If it is not above `STEP_HEIGHT_M`.
    """
    if not (math.isfinite(robot_height_m) and robot_height_m > STEP_HEIGHT_M):
        raise ValueError(
            f"robot_height_m is {robot_height_m}; give metres, more than the {STEP_HEIGHT_M:g} m "
            "of a step"
        )
