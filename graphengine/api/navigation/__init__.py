"""Sends goals to Nav2 and compares where its robot is with where it believes to be."""
