"""Driving the robot live: the loop in its own process, and the person at its controls."""
