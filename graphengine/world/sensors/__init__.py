"""What robots sense with: profiles as data, and the handles that cast, render and measure."""
