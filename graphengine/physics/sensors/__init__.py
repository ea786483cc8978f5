"""What robots sense with: handles that cast rays, take pictures and measure at their own rates."""
