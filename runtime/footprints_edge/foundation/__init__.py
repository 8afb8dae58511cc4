"""The base of all other parts: array types, atomic writes, cores, PNG, OpenCV, version, hints."""
