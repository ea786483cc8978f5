"""Views of a scene for users: names, cameras that frame or follow robots, and their images."""
