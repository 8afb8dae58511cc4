"""What the tests' tiny models say about themselves."""

from footprints_edge.model_files.metadata import ModelMetadata

TINY = ModelMetadata(
    name="tiny",
    architecture="edge",
    precision="fp32",
    depth_range_m=(0.1, 100.0),
    focal_px=None,
    resize="lanczos",
    licence="Apache-2.0",
    source_sha256="0" * 64,
    producer="tests",
    training="none: the maps are the colours",
)
