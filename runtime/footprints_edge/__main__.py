"""``python -m footprints_edge`` is ``fp-infer``."""

from footprints_edge.cli.infer import main

if __name__ == "__main__":
    main()
