"""The robots' sensors: handles that cast rays, capture images or measure forces and motion, each at its own rate."""
