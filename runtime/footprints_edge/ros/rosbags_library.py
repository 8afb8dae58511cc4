"""The only module that imports rosbags, which comes with the extra `ros`."""

from functools import cache
from pathlib import Path
from typing import Any

from footprints_edge.errors import BagError
from footprints_edge.foundation.install_hint import install_hint

_TF_MESSAGE = "geometry_msgs/TransformStamped[] transforms\n"


def rosbags() -> Any:  # noqa: ANN401 - the library is optional
    """The package `rosbags`, with the parts that are used imported.

    Raises:
        BagError: If it is not installed.
    """
    try:
        import rosbags
        import rosbags.highlevel
        import rosbags.interfaces
        import rosbags.rosbag1
        import rosbags.rosbag2
        import rosbags.typesys
    except ModuleNotFoundError as error:
        raise BagError(f"bags need the package {error.name}; {install_hint('ros')}") from None
    return rosbags


@cache
def message_types(ros: int) -> Any:  # noqa: ANN401 - likewise
    """The message types of ROS 1, or of ROS 2, in which those used here have not changed.

    Raises:
        BagError: If rosbags is not installed.
    """
    typesys = rosbags().typesys
    if ros == 2:
        return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    types = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    types.register(typesys.get_types_from_msg(_TF_MESSAGE, "tf2_msgs/msg/TFMessage"))
    return types


def open_reader(path: Path) -> Any:  # noqa: ANN401 - likewise
    """An open reader of a bag of ROS 1 or ROS 2, which may lack its message definitions.

    Raises:
        BagError: If it cannot be read, or rosbags is not installed.
        OSError: Likewise.
    """
    reader_class = rosbags().highlevel.AnyReader
    try:
        reader = reader_class([path], default_typestore=message_types(2))
        reader.open()
    except OSError:
        raise
    except Exception as error:  # damaged files give any error of their parsers
        raise BagError(
            f"{path} cannot be read as a bag ({type(error).__name__}: {error}); "
            "ROS's own `ros2 bag reindex`, `mcap recover` or `rosbag reindex` may repair it"
        ) from error
    return reader
