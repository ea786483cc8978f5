"""Reads robot descriptions, with the robot file that names them or with a generated one."""
