"""``python -m footprints_edge`` runs ``fp-infer``."""

from footprints_edge.cli.start import infer

if __name__ == "__main__":
    infer()
