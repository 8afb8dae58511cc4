"""Prints what a JSON file of `fp-infer` says, in one line.

fp-infer picture.jpg --format json
python examples/read_result.py picture.jpg.json
"""

import json
import sys
from pathlib import Path


def in_one_line(result: dict) -> str:
    """Share of the picture that is floor, its nearest point, and the camera's height above it."""
    share, nearest_m = result["ground_fraction"], result["ground_distance_m"]["nearest"]
    if nearest_m is None:
        return "no floor found"
    plane = result["ground_plane"]  # None where the ground is not flat
    line = (
        f"floor on {share['all']:.0%} of the picture ({share['hidden']:.0%} hidden), "
        f"nearest {nearest_m:.1f} m"
    )
    return line + (f", camera {plane['camera_height_m']:.1f} m high" if plane else "")


if __name__ == "__main__":
    result = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    sys.stdout.write(in_one_line(result) + "\n")
