"""Files with which Nav2 drives the robots of a scene: parameters, map, launch file and RViz configuration."""
