"""Readers of recordings of messages on topics: MCAP of any tool, ROS 1 and ROS 2 bags."""
