"""Sends goals to Nav2 and compares the true poses of the robot with Nav2's estimates."""
