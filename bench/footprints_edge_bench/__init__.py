"""Benchmarks of the models: accuracy, navigation, temporal consistency, speed."""

import footprints_edge  # noqa: F401 - it keeps onnxruntime from reporting to its maker
