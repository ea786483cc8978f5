"""A recording as one HTML file: its script, style and data are inside, and a browser opens it from disk."""
