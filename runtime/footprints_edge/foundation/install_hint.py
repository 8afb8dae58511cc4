"""How to install an extra of this package."""


def install_hint(extra: str) -> str:
    """The advice for an error message about a missing package of an extra, such as `video`.

    Several extras are joined by commas, as pip has them.
    """
    return (
        f"install the extra {extra!r}: pip install 'footprints-edge[{extra}]', "
        f"or pip install '.[{extra}]' in a checkout"
    )
