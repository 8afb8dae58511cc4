"""Runs ``fp-bench`` as ``python -m footprints_edge_bench.cli``."""

from footprints_edge_bench.cli import main

if __name__ == "__main__":
    main()
