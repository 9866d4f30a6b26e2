"""Our nouns as ROS 2 messages, and a log of them in MCAP."""
