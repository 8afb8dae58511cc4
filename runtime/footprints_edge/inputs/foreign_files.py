"""Pictures that cannot be read, by name: photos of phones, raw files of cameras, and others."""

from pathlib import Path

HEIF_SUFFIXES = frozenset({".heic", ".heif", ".hif"})
AVIF_SUFFIXES = frozenset({".avif"})
RAW_SUFFIXES = frozenset(
    {".dng", ".nef", ".nrw", ".cr2", ".cr3", ".crw", ".arw", ".sr2", ".orf", ".rw2", ".raf", ".pef"}
    | {".srw", ".raw", ".x3f", ".3fr", ".iiq", ".erf", ".kdc", ".dcr", ".mrw", ".rwl"}
)
OTHER_SUFFIXES = frozenset(
    {".gif", ".jp2", ".j2k", ".jxl", ".psd", ".tga", ".exr", ".hdr", ".ico", ".svg", ".ppm", ".pgm"}
)

UNREAD_SUFFIXES = HEIF_SUFFIXES | AVIF_SUFFIXES | RAW_SUFFIXES | OTHER_SUFFIXES
"""Suffixes of pictures that a folder may hold and that are not read everywhere, or nowhere."""

_HEIF_BRANDS = {b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1"}
_AVIF_BRANDS = {b"avif", b"avis"}
_RAW_STARTS = (b"FUJIFILMCCD-RAW", b"IIU\x00", b"IIRO", b"IIRS", b"MMOR", b"FOVb", b"\x00MRM")

_RAW_ADVICE = (
    "is a raw file of a camera, which holds no finished picture but a thumbnail; develop it first, "
    "to JPEG or TIFF"
)
_DNG_VERSION, _NEW_SUBFILE_TYPE, _SUB_IFDS = 50706, 254, 330


def is_heif(data: bytes) -> bool:
    """Whether these are the bytes of a HEIC file, as phones write them."""
    return data[4:8] == b"ftyp" and data[8:12] in _HEIF_BRANDS and b"avif" not in data[8:64]


def is_avif(data: bytes) -> bool:
    """Whether these are the bytes of an AVIF file."""
    return data[4:8] == b"ftyp" and (data[8:12] in _AVIF_BRANDS or b"avif" in data[8:64])


def raw_reason(data: bytes, path: Path | None) -> str | None:
    """Why a file is refused as a raw file, by its name or its first bytes; None if it is none."""
    by_name = path is not None and path.suffix.lower() in RAW_SUFFIXES
    by_content = data.startswith(_RAW_STARTS) or data[8:12] == b"CR\x02\x00"
    return _RAW_ADVICE if by_name or by_content or data[4:12] == b"ftypcrx " else None


def raw_tiff_reason(tags: object) -> str | None:
    """The same by the tags of a TIFF file: raw files begin with a thumbnail."""
    if not hasattr(tags, "get"):
        return None
    is_thumbnail = tags.get(_NEW_SUBFILE_TYPE) == 1 and tags.get(_SUB_IFDS) is not None
    return _RAW_ADVICE if is_thumbnail or tags.get(_DNG_VERSION) is not None else None
