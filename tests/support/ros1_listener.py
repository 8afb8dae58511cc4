"""Run by a Python that has ROS 1: plays the grids of a bag on a topic, or listens to that topic.

ros1_listener.py play BAG TOPIC        ros1_listener.py listen COUNT TOPIC
"""

import hashlib
import sys
import threading
import time


def play(bag, topic):
    import rosbag
    import rospy
    from nav_msgs.msg import OccupancyGrid

    publisher = rospy.Publisher(topic, OccupancyGrid, queue_size=100)
    deadline = time.monotonic() + 30
    while not publisher.get_num_connections() and time.monotonic() < deadline:
        time.sleep(0.02)
    for _, message, _ in rosbag.Bag(bag).read_messages(topics=[topic]):
        publisher.publish(message)
    while publisher.get_num_connections() and time.monotonic() < deadline:
        time.sleep(0.02)  # until the listener has them all


def listen(count, topic):
    import rospy
    from nav_msgs.msg import OccupancyGrid

    done, left = threading.Event(), [int(count)]

    def on_grid(grid):
        stamp, cells = grid.header.stamp, bytes(each & 255 for each in grid.data)
        digest = hashlib.sha256(cells).hexdigest()
        print(stamp.secs, stamp.nsecs, grid.header.frame_id, grid.info.width, digest)
        left[0] -= 1
        if not left[0]:
            done.set()

    rospy.Subscriber(topic, OccupancyGrid, on_grid)
    assert done.wait(30), "no messages came"


if __name__ == "__main__":
    import rospy

    rospy.init_node(sys.argv[1], anonymous=True, disable_signals=True)
    {"play": play, "listen": listen}[sys.argv[1]](*sys.argv[2:])
