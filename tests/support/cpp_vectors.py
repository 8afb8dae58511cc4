"""What the C++ program for test vectors is told."""

from typing import Any


def words_of(entry: dict[str, Any]) -> list[object]:
    """Of a vector, in the order of `run_vectors`."""
    camera, pose, grid = entry["image_intrinsics_px"], entry["known_pose"], entry["grid"]
    known = [pose[key] for key in ("camera_height_m", "pitch_deg", "roll_deg")]
    path = entry["path"]
    return [
        *(camera[key] for key in ("fx", "fy", "cx", "cy")),
        *entry["network_size_px"],
        *("nan" if each is None else each for each in known),
        *(grid["cell_m"], grid["range_m"], grid["robot_height_m"]),
        *([] if path is None else [*path["start_px"], *path["goal_px"], path["margin_m"]]),
    ]
