"""Whom to credit for a dataset: what its ``credits.json`` says, or what is known of its name."""

from pathlib import Path

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import CREDITS, read_credits_file

_NOT_STATED = "not stated"

KNOWN = {
    "idd_lite": Credit(
        "IDD-Lite",
        "Varma et al., IIIT Hyderabad",
        "IDD: non-commercial research",
        "https://idd.insaan.iiit.ac.in",
    ),
    "camvid": Credit(
        "CamVid",
        "Brostow, Fauqueur and Cipolla, University of Cambridge",
        "CC-BY-NC-4.0",
        "http://mi.eng.cam.ac.uk/research/projects/VideoRec/CamVid/",
    ),
    "houses": Credit("photos of houses and rooms", _NOT_STATED, _NOT_STATED, ""),
    "openimages": Credit(
        "photos of Open Images, from the DoorDetect data set",
        "their photographers, on Flickr; each photo is named by its id",
        "CC-BY-2.0",
        "https://github.com/MiguelARD/DoorDetect-Dataset",
    ),
    "hololens_office": Credit(
        "HoloLens office walk, sample of DeepVideoMVS",
        "Arda Duzceker",
        "MIT",
        "https://github.com/ardaduz/deep-video-mvs",
    ),
    "seven_scenes_kitchen": Credit(
        "7-Scenes, kitchen",
        "Shotton et al., Microsoft Research",
        "Microsoft 7-Scenes: non-commercial",
        "https://www.microsoft.com/en-us/research/project/rgb-d-dataset-7-scenes/",
    ),
    **dict.fromkeys(
        ("kitti_grey_stereo", "kitti_raw", "kitti_training_data"),
        Credit(
            "KITTI", "Geiger et al., KIT and TTI Chicago", "CC-BY-NC-SA-3.0",
            "https://www.cvlibs.net/datasets/kitti/",
        ),
    ),
    **dict.fromkeys(
        ("matterport_raw", "matterport_training_data"),
        Credit(
            "Matterport3D", "Chang et al.", "Matterport3D terms of use: non-commercial",
            "https://niessner.github.io/Matterport/",
        ),
    ),
    "synthetic_scenes": None,
}  # fmt: skip
"""By name of the folder; None: made by this program, out of nothing that has an author."""


def dataset_credits(folder: Path) -> tuple[Credit, ...]:
    """The credits of a dataset, from the file in its folder before what is known of its name.

    One of another name without a file is credited by its name alone: that its author and licence
    are not stated is worth knowing, too.

    Raises:
        AssetError: the file is damaged.
    """
    path = folder / CREDITS
    if path.is_file():
        return tuple(read_credits_file(path))
    known = KNOWN.get(folder.name, Credit(folder.name, _NOT_STATED, _NOT_STATED, ""))
    return () if known is None else (known,)


def photo_credits(folder: Path) -> tuple[Credit, ...]:
    """The credits of a folder of photos: those of the dataset that it is, or is a part of.

    Raises:
        AssetError: the dataset's file is damaged.
    """
    folder = folder.resolve()
    for place in (folder, *folder.parents):
        if place.name in KNOWN or (place / CREDITS).is_file():
            return dataset_credits(place)
    return dataset_credits(folder)
