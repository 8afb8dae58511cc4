"""``python -m footprints_edge_models.cli``."""

from footprints_edge_models.cli import main

main()
