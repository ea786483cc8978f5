"""Files of occupancy maps, and localizability: how well AMCL could localize a robot at each place of a map."""
