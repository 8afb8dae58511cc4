"""ROS: pictures out of bags and messages, and the ground as the messages that robots read."""
