"""The robots' sensors: handles that cast rays, take pictures and measure at their own rates."""
