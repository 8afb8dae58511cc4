"""``python -m footprints_edge`` runs ``fp-infer``."""

from footprints_edge.cli.infer import main

if __name__ == "__main__":
    main()
