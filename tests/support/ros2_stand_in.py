"""What `examples/ros2` uses of rclpy and launch, for where ROS is absent.

Messages have the fields of rosbags' definitions, and take what rclpy's setters take: numbers and
texts of Python, lists of messages, and arrays of the standard library, of the right type.
"""

import sys
from array import array
from dataclasses import fields
from types import ModuleType, SimpleNamespace

from footprints_edge.ros.rosbags_library import message_types

_TYPECODES = {
    "int8": "b",
    "uint8": "B",
    "float32": "f",
    "float64": "d",
}


def message_class(kind):
    """A class of messages as rclpy has it."""
    known = {field.name: str(field.type) for field in fields(message_types(2).types[kind])}

    def init(self, **given):
        for name, value in given.items():
            check(f"{kind}.{name}", known[name], value)
            setattr(self, name, value)

    return type(kind.rpartition("/")[2], (), {"__init__": init, "kind": kind})


def check(name, wanted, value):
    """Fails where a setter of rclpy would."""
    if "ndarray" in wanted:
        code = next(code for dtype, code in _TYPECODES.items() if f".{dtype}]" in wanted)
        assert isinstance(value, array) and value.typecode == code, (name, wanted, type(value))
    elif wanted.startswith("list["):
        assert isinstance(value, list), (name, type(value))
        assert all(each.kind.replace("/", "__") in wanted for each in value), (name, wanted)
    elif wanted in {"int", "float", "str", "bool"}:
        assert type(value).__name__ == wanted, (name, wanted, type(value))
    else:
        assert value.kind.replace("/", "__") == wanted, (name, wanted, type(value))


class Publisher:
    def __init__(self, kind, topic, qos):
        self.kind, self.topic, self.qos, self.sent = kind, topic, qos, []

    def publish(self, message):
        assert isinstance(message, self.kind)
        self.sent.append(message)


class Node:
    parameters = None
    """What `--ros-args -p` gives."""

    def __init__(self, name):
        self.name, self.publishers, self.subscriptions, self.warnings = name, {}, {}, []

    def declare_parameter(self, name, default):
        value = (self.parameters or {}).get(name, default)
        assert type(value) is type(default), name
        return SimpleNamespace(value=value)

    def create_publisher(self, kind, topic, qos):
        self.publishers[topic] = Publisher(kind, topic, qos)
        return self.publishers[topic]

    def create_subscription(self, kind, topic, callback, qos):
        self.subscriptions[topic] = (kind, callback, qos)

    def get_logger(self):
        def warning(text, throttle_duration_sec):
            self.warnings.append((text, throttle_duration_sec))

        return SimpleNamespace(warning=warning)


def record(name):
    """A class whose objects keep their arguments."""

    def init(self, *given, **named):
        self.given, self.named = given, named

    return type(name, (), {"__init__": init})


def install(monkeypatch):
    """Puts the modules where `import` finds them; returns the function `get_message`."""
    classes = {}

    def get_message(kind):
        return classes.setdefault(kind, message_class(kind))

    policy = SimpleNamespace(BEST_EFFORT="best effort", TRANSIENT_LOCAL="transient local")
    modules = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {
            "QoSProfile": SimpleNamespace,
            "DurabilityPolicy": policy,
            "ReliabilityPolicy": policy,
        },
        "rosidl_runtime_py": {},
        "rosidl_runtime_py.utilities": {"get_message": get_message},
        "sensor_msgs": {},
        "sensor_msgs.msg": {
            name: get_message(f"sensor_msgs/msg/{name}") for name in ("CameraInfo", "Image")
        },
        "launch": {"LaunchDescription": record("LaunchDescription")},
        "launch.actions": {
            name: record(name) for name in ("DeclareLaunchArgument", "ExecuteProcess")
        },
        "launch.conditions": {"IfCondition": record("IfCondition")},
        "launch.substitutions": {"LaunchConfiguration": record("LaunchConfiguration")},
    }
    for name, content in modules.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    return get_message
