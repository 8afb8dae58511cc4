"""The base of all other parts: array types, atomic writes, cores, PNG, OpenCV, the version."""
