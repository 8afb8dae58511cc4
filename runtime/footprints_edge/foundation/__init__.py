"""What everything else stands on: array types, atomic writes, cores, PNG, OpenCV, the version."""
